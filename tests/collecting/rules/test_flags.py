"""Flags of verifiers, by tables."""

import pytest

from arramon_collecting.rules.flags import FLAGS, kinds_by_part, read_flags
from arramon_server.errors import BadInput


def test_there_is_a_flag_for_each_kind_and_text() -> None:
    assert len(FLAGS) == len(set(FLAGS)) == 16


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ([], ()),
        (
            ["2-assembly-wrong", "1-navigation-unclear", "2-assembly-wrong"],
            ("1-navigation-unclear", "2-assembly-wrong"),
        ),
    ],
)
def test_flags_are_read(given: object, expected: tuple[str, ...]) -> None:
    assert read_flags(given) == expected


@pytest.mark.parametrize(
    "given", [None, "1-navigation-unclear", {}, ["unclear"], [1], [["1-navigation-unclear"]], ["\0"], [FLAGS[0]] * 17]
)
def test_anything_else_is_refused(given: object) -> None:
    with pytest.raises(BadInput):
        read_flags(given)


def test_flags_by_text() -> None:
    flags = ["1-navigation-unclear", "1-navigation-wrong", "2-assembly-other_language"]
    assert kinds_by_part(flags) == {"1-navigation": ["unclear", "wrong"], "2-assembly": ["other_language"]}

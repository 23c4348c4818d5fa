"""Agreement of verifiers, by tables."""

import pytest

from arramon_collecting.rules.agreement import (
    Agreement,
    Walk,
    agreement_of,
    agreement_with_others,
    flag_alpha,
    path_similarity,
    simplified,
)

STREET = ((0.0, 0.0), (0.0, 1.0), (0.0, 2.0))
AWAY = ((0.0, 0.0), (0.0, -300.0), (0.0, -600.0))
TWO_CODERS = ([0, 1, 0, 0, 0, 0, 0, 0, 1, 0], [1, 1, 1, 0, 0, 1, 0, 0, 0, 0])
A, B = (2, 1, 2), (3, 1, 2)


def walk(worker_id: str, *flags: str, path: tuple[tuple[float, float], ...] = STREET, cell: object = A) -> Walk:
    return Walk(worker_id, (path, path), (cell, A), frozenset(flags))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("walks", "expected"),
    [
        ([], Agreement(None, None)),
        ([walk("a")], Agreement(None, None)),
        ([walk("a"), walk("b")], Agreement(1.0, 1.0)),
        ([walk("a"), walk("b", cell=B)], Agreement(1.0, 0.5)),
        ([walk("a"), walk("b", cell=None), walk("c", cell=None)], Agreement(1.0, 0.5)),  # nowhere is no common cell
        ([walk("a"), walk("b", path=())], Agreement(0.0, 1.0)),
    ],
)
def test_agreement_on_a_text(walks: list[Walk], expected: Agreement) -> None:
    assert agreement_of(walks) == expected


def test_ways_that_part_do_not_agree() -> None:
    assert path_similarity(STREET, STREET) == 1.0
    assert path_similarity(STREET, AWAY) == path_similarity(AWAY, STREET) < 1e-9
    assert 0.5 < path_similarity(STREET, STREET[:2]) < 1.0


def test_agreement_of_a_worker_is_with_others_alone() -> None:
    texts = {"t1": [walk("a"), walk("b"), walk("c", cell=B)], "t2": [walk("b"), walk("c")]}
    assert agreement_with_others("a", texts) == Agreement(1.0, 0.75)
    assert agreement_with_others("d", texts) == Agreement(None, None)


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        ({"t1": [walk("a", "wrong"), walk("b", "wrong")], "t2": [walk("a"), walk("b")]}, 1.0),
        # Krippendorff's own example of two coders and nominal data has 0.095 (Computing alpha, 2011, B).
        (
            {
                str(unit): [walk("a", *["wrong"] * one), walk("b", *["wrong"] * two)]
                for unit, (one, two) in enumerate(zip(*TWO_CODERS, strict=True))
            },
            0.095,
        ),
        ({"t1": [walk("a"), walk("b")]}, None),  # all alike
        ({"t1": [walk("a", "wrong")], "t2": [walk("b")]}, None),  # nobody flags the same text
        ({}, None),
    ],
)  # fmt: skip
def test_alpha_over_flags(texts: dict[str, list[Walk]], expected: float | None) -> None:
    pytest.importorskip("krippendorff", reason="it is an extra: pip install 'arramon-server[collecting]'")
    found = flag_alpha(texts, ["wrong"])
    assert found == (None if expected is None else pytest.approx(expected, abs=0.0005))


def test_a_path_is_stored_without_turns_on_the_spot() -> None:
    path = [(0.0, 0.0), (0.0, 0.0), (0.001, 0.499), (0.0, 0.5), (0.0, 1.0)]
    assert simplified(path) == ((0.0, 0.0), (0.0, 0.5), (0.0, 1.0))
    assert simplified([]) == ()

"""Signatures: one line that can be parsed again."""

import dataclasses
from urllib.parse import unquote

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arramon_server.scoring.signature import Signature, format_argument

SIGNATURE = Signature("0.1.0", 1, "val_seen", "en", 1065, 150, "60/86400", frozenset({"rgb", "depth"}),
                      frozenset({"lossless-224"}), "ab12")  # fmt: skip
LINE = (
    "split:val_seen|lang:en|episodes:1065|steps:150|clock:60/86400|sensors:depth+rgb|images:lossless-224|protocol:1|"
    "version:0.1.0|data:ab12"
)


def test_signature_is_one_parsable_line() -> None:
    assert str(SIGNATURE) == LINE
    assert Signature.parse(LINE + "\n") == SIGNATURE


def test_missing_sensors_and_images_are_written_as_none() -> None:
    blind = dataclasses.replace(SIGNATURE, sensors=frozenset(), images=frozenset())
    assert "|sensors:none|images:none|" in str(blind)
    assert Signature.parse(str(blind)) == blind


def test_arguments_and_chosen_episodes_are_appended() -> None:
    written = {format_argument("beam", "4"), format_argument("checkpoint", "my w+|%.pt")}
    full = dataclasses.replace(SIGNATURE, arguments=frozenset(written), chosen="ab12cd")
    assert str(full) == LINE + "|args:beam=4+checkpoint=my%20w%2B%7C%25.pt|chosen:ab12cd"
    assert Signature.parse(str(full)) == full


@given(st.text())
def test_every_argument_can_be_written_and_parsed(value: str) -> None:
    written = format_argument("a", value)
    signature = dataclasses.replace(SIGNATURE, arguments=frozenset({written}))
    assert Signature.parse(str(signature)).arguments == {written}
    assert unquote(written) == f"a={value}"


words = st.text("abnoe019_.:-", min_size=1, max_size=8)
some = st.frozensets(words.filter(lambda word: word != "none"))


@given(st.builds(Signature, words, st.integers(), words, words, st.integers(), st.integers(),
                 words, some, some, words, some, st.just("") | words))  # fmt: skip
def test_every_signature_can_be_parsed_back(signature: Signature) -> None:
    assert Signature.parse(str(signature)) == signature


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("", "no field 'version'"),
        (LINE.replace("|data:ab12", ""), "no field 'data'"),
        (LINE.replace("1065", "many"), "many"),
        (LINE.replace("depth+rgb", "rgb+depth"), "expected"),
        (LINE + "|more:1", "expected"),
        (LINE.replace("split:val_seen", "split:"), "''"),
    ],
)
def test_malformed_lines_are_refused(line: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Signature.parse(line)


@pytest.mark.parametrize("word", ["", "val|seen", "val seen", "a\nb", "a+b"])
def test_words_that_cannot_be_parsed_back_are_refused(word: str) -> None:
    with pytest.raises(ValueError, match="is not allowed in a signature"):
        dataclasses.replace(SIGNATURE, split=word)


def test_a_sensor_called_none_is_refused() -> None:
    with pytest.raises(ValueError, match="none"):
        dataclasses.replace(SIGNATURE, sensors=frozenset({"none"}))
    with pytest.raises(ValueError, match="none"):
        dataclasses.replace(SIGNATURE, images=frozenset({"none"}))

"""Workers' texts: normalised, bounded, and without what cannot be seen."""

import pytest

from arramon_collecting.rules.clean_text import clean_instruction, clean_instructions
from arramon_server.errors import BadInput


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("  Turn\tleft,\n then  go. ", "Turn left, then go."),
        ("cafe\u0301", "café"),
        ("क\u094d\u200dष बाएँ मुड़ें", "क\u094d\u200dष बाएँ मुड़ें"),  # a joiner within a word
        ("\u0958", "\u0915\u093c"),  # NFC writes this letter as two
        ("Turn 90° to the left.", "Turn 90° to the left."),
    ],
)
def test_texts_are_normalised(text: str, expected: str) -> None:
    assert clean_instruction(text, 100) == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the instruction is empty"),
        (" \n\t ", "the instruction is empty"),
        ("a" * 101, "the instruction has 101 characters; at most 100 are allowed"),
        ("a" * 100_000, "the instruction has 100000 characters; at most 100 are allowed"),
        ("Go\u200bleft", r"the instruction has an invisible character, U\+200B \(ZERO WIDTH SPACE\)"),
        ("\u200d left", r"invisible character, U\+200D \(ZERO WIDTH JOINER\) alone"),
        ("Go \u202eleft", r"the instruction has a mark of text direction, U\+202E"),
        ("Go \u200fleft", r"the instruction has a mark of text direction, U\+200F"),
        ("Go \N{WAVING HAND SIGN}", r"the instruction has the symbol \N{WAVING HAND SIGN} \(U\+1F44B\)"),
        ("Go\x00left", r"an invisible character, U\+0000"),
        ("Go \ud83d", "the instruction has half a character"),
        ("Zalgo" + "\u0301" * 9, "after 4 other marks"),
    ],
)
def test_what_is_no_plain_text_is_refused_by_name(text: str, message: str) -> None:
    with pytest.raises(BadInput, match=message):
        clean_instruction(text, 100)


@pytest.mark.parametrize("texts", [None, [], [["a", "b"]], [["a", "b"], ["c"]], [["a", "b"], ["c", 1]], {"a": 1}])
def test_other_shapes_are_refused(texts: object) -> None:
    with pytest.raises(BadInput, match="instructions"):
        clean_instructions(texts, 100)


def test_the_faulty_text_is_named() -> None:
    with pytest.raises(BadInput, match="the assembly instruction of turn 2 is empty"):
        clean_instructions([["a", "b"], ["c", " "]], 100)
    assert clean_instructions([["a ", "b"], ["c", "d"]], 100) == (("a", "b"), ("c", "d"))

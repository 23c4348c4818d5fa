"""Texts from strangers, made safe."""

import json
import sys
import unicodedata

import pytest

from arramon_client.printable import many_lines, one_line, to_json

KEPT = "\u200c\u200d\u0600\u0601\u0602\u0603\u0604\u0605\u06dd\u070f\u0890\u0891\u08e2\U000110bd\U000110cd"
"""Format characters that are seen, or that scripts need."""


@pytest.mark.parametrize("category", ["Cc", "Cf", "Cs", "Zl", "Zp"])
def test_no_character_of_control_is_left(category: str) -> None:
    letters = [chr(code) for code in range(sys.maxunicode + 1) if unicodedata.category(chr(code)) == category]
    assert letters
    hieroglyphs = range(0x13430, 0x13440)  # They join hieroglyphs, and are seen.
    for letter in letters:
        if letter in KEPT or ord(letter) in hieroglyphs:
            continue
        assert letter not in one_line(f"a{letter}b"), hex(ord(letter))
        assert letter in "\t\n" or letter not in many_lines(f"a{letter}b"), hex(ord(letter))


@pytest.mark.parametrize(("text", "line"), [
    ("agents.vl", "agents.vl"),
    ("मेरा एजेंट क्\u200dष", "मेरा एजेंट क्\u200dष"),
    ("a\nb\r\n\tc", "a b c"),
    ("\x1b[31mred", "\ufffd[31mred"),
    ("x" * 600, "x" * 499 + "…"),
    ("e" + "\u0301" * 100 + "f", "e" + "\u0301" * 8 + "f"),
    ("e" + ("\u0301" * 8 + "\u200d") * 40 + "f", "e" + "\u0301" * 8 + "\u200d" + "f"),
    ("❤\ufe0f👨\u200d👩", "❤\ufe0f👨\u200d👩"),
    ("a\u3164b\u115fc\u2800d\u034fe\ufe00f\U000e0100g", "a\ufffdb\ufffdc\ufffdd\ufffde\ufffdf\ufffdg"),
    ("", ""),
])  # fmt: skip
def test_one_line(text: str, line: str) -> None:
    assert one_line(text) == line


def test_many_lines_keeps_lines_of_both_kinds() -> None:
    assert many_lines("a\r\nb\n\tc\rd") == "a\r\nb\n\tc\ufffdd"


def test_json_holds_every_text_and_no_control_characters() -> None:
    content = {"a": ["\x1b\x9b\u202e\U000e0041 नमस्ते \ud800", {"b\u200b": 1}]}
    text = to_json(content)
    assert json.loads(text) == content
    assert "नमस्ते" in text
    assert not any(letter in text for letter in "\x1b\x9b\u202e\u200b\ud800\U000e0041")

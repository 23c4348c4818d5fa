"""Which texts of participants are accepted, and how others are shown."""

import pytest

from arramon_server.visible_text import invisible_part, is_visible, shown, shown_lines


@pytest.mark.parametrize(
    "text",
    [
        "",
        "a note, with (marks): 100% & <b>",
        "Ann Müller-Öz",
        "Nguye\u0302\u0303n",
        "हिन्दी में क्‍ष और क्‌ष, श्रीमान्‌",  # with joiner and non-joiner
        "می‌خواهم",
        "👩‍🔬 ❤️ ✔︎",
        "日本語",
        "a" + 4 * "\u0336",
    ],
)
def test_visible_lines_are_accepted_and_shown_unchanged(text: str) -> None:
    assert is_visible(text)
    assert shown(text) == text


@pytest.mark.parametrize(
    ("text", "part", "as_shown"),
    [
        ("a\u200bb", "U+200B (ZERO WIDTH SPACE)", "a\ufffdb"),
        ("a\u2063b", "U+2063 (INVISIBLE SEPARATOR)", "a\ufffdb"),
        ("a\u2060b", "U+2060 (WORD JOINER)", "a\ufffdb"),
        ("a\ufeffb", "U+FEFF (ZERO WIDTH NO-BREAK SPACE)", "a\ufffdb"),
        ("a\u00adb", "U+00AD (SOFT HYPHEN)", "a\ufffdb"),
        ("a\U000e0041b", "U+E0041 (TAG LATIN CAPITAL LETTER A)", "a\ufffdb"),
        ("a\u202eb", "U+202E (RIGHT-TO-LEFT OVERRIDE)", "a\ufffdb"),
        ("a\u2066b", "U+2066 (LEFT-TO-RIGHT ISOLATE)", "a\ufffdb"),
        ("a\nb", "U+000A (a control character)", "a\ufffdb"),
        ("a\x1b[2Jb", "U+001B (a control character)", "a\ufffd[2Jb"),
        ("a\x9bb", "U+009B (a control character)", "a\ufffdb"),
        ("a\u2028b", "U+2028 (LINE SEPARATOR)", "a\ufffdb"),
        ("a\u3164b", "U+3164 (HANGUL FILLER)", "a\ufffdb"),
        ("a\u034fb", "U+034F (COMBINING GRAPHEME JOINER)", "a\ufffdb"),
        ("a\U000e0100b", "U+E0100 (VARIATION SELECTOR-17)", "a\ufffdb"),
        ("a\ue000b", "U+E000", "a\ufffdb"),
        ("a\u00a0b", "U+00A0 (NO-BREAK SPACE)", "a\u00a0b"),
        ("a" + 5 * "\u0336", "U+0336 (COMBINING LONG STROKE OVERLAY) after 4 other marks", "a" + 4 * "\u0336"),
        (
            "a" + "\u0336\u200d" * 5,
            "U+0336 (COMBINING LONG STROKE OVERLAY) after 4 other marks",
            "a" + "\u0336\u200d" * 4,
        ),
        ("\u0301a", "U+0301 (COMBINING ACUTE ACCENT) after no letter", "\u0301a"),
        ("\u200d", "U+200D (ZERO WIDTH JOINER) alone", "\u200d"),
        ("a \u200cb", "U+200C (ZERO WIDTH NON-JOINER) alone", "a \u200cb"),
        ("क\u200d\u200d", "U+200D (ZERO WIDTH JOINER) alone", "क\u200d\u200d"),
        ("\ufe0f", "U+FE0F (VARIATION SELECTOR-16) alone", "\ufe0f"),
        ("a\ufe0f\ufe0f", "U+FE0F (VARIATION SELECTOR-16) alone", "a\ufe0f\ufe0f"),
    ],
)
def test_others_are_refused_by_the_name_of_the_character(text: str, part: str, as_shown: str) -> None:
    assert invisible_part(text) == part
    assert not is_visible(text)
    assert shown(text) == as_shown


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", ""),
        ('{"at": [1, 2]}\n\tturn left', '{"at": [1, 2]}\n\tturn left'),
        ("one\r\ntwo\rthree\n", "one\ntwo\nthree\n"),
        ("बाईं ओर\n\tमुड़ें", "बाईं ओर\n\tमुड़ें"),
        ("a\x1b[2J\x00\nb\u202ec", "a\ufffd[2J\ufffd\nb\ufffdc"),
        ("a\x0bb\x0cc\u2028d", "a\ufffdb\ufffdc\ufffdd"),
        ("a" + 5 * "\u0336" + "\n" + 5 * "\u0336", "a" + 4 * "\u0336" + "\n" + 4 * "\u0336"),
    ],
)
def test_texts_of_several_lines_keep_their_lines_and_tabs(text: str, expected: str) -> None:
    assert shown_lines(text) == expected
    assert shown_lines(expected) == expected

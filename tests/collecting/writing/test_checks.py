"""Checks of texts as they are written: what each finds, where it is, and how severe it is."""

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest

from arramon_collecting.storage.texts.records import HINT
from arramon_collecting.writing.characters import stored_form
from arramon_collecting.writing.checks import TextChecker, any_blocks
from arramon_dataset.paraphrases.collection import (
    generated_episodes,
    paraphrased_episodes,
    paraphrased_section,
    paraphrases,
)
from arramon_lang.quality import BLOCKED, SUSPICIOUS
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.room import RoomPosition
from arramon_server.sim.rules import PlacedObject
from arramon_server.sim.section import Prop
from tests import tiny
from tests.lang.test_third_language import FILES

FACE = "\N{GRINNING FACE}"


def checker(language: str = "en", most: int = 1000) -> TextChecker:
    return TextChecker(tiny.episode("0"), tiny.SECTION, language, most)


GOOD = "Walk straight ahead to the brick building and pick up the striped red mug."


@pytest.mark.parametrize(
    ("language", "part", "text", "check", "severity", "at"),
    [
        ("en", 0, "Walk to the brick building and pick up the (striped red mug.", "symbol", BLOCKED, ["("]),
        ("en", 0, "Walk three Steps and pick up the striped red mug.", "term", BLOCKED, ["Steps"]),
        ("en", 0, "Walk on and Go  back to pick up the striped red mug.", "term", BLOCKED, ["Go  back"]),
        ("en", 0, "Walk to to the building, pick up the striped red mug.", "repeated_word", BLOCKED, ["to to"]),
        ("en", 0, "Walk past the brick bbbuilding, pick up the striped red mug.", "repeated_letter", BLOCKED, ["bbb"]),
        ("en", 2, "Walk straight ahead and pick up the dotted blue tv.", "no_turn", BLOCKED, []),
        ("en", 0, "Walk along the blue line and pick up the striped red mug.", "interface", SUSPICIOUS, ["blue line"]),
        ("en", 1, "Move it, place the striped red mug near the dotted white bowl.", "term", BLOCKED, ["Move"]),
        ("en", 0, f"Walk on and pick up the striped red mug {FACE} there.", "picture", BLOCKED, [FACE]),
        ("en", 0, "Walk on\u200b and pick up the striped red mug there.", "invisible", BLOCKED, ["\u200b"]),
        ("en", 0, "Walk on and pick up the \u202estriped red mug there.", "invisible", BLOCKED, ["\u202e"]),
        ("en", 0, "Walk on and pick up the \u200d striped red mug.", "invisible", BLOCKED, ["\u200d"]),
        ("en", 0, "Walk on and pick up the stri\u200dped red mug.", "normalisation", SUSPICIOUS, []),
        ("hi", 0, "सीधे चलें और बाएं रखा धारीदार लाल मग उठा लें।", "misspelt", SUSPICIOUS, ["बाएं"]),
        ("hi", 0, "चाबी दबाकर सीधे चलें और धारीदार लाल मग उठा लें।", "term", BLOCKED, ["चाबी"]),
    ],
)  # fmt: skip
def test_each_finding_marks_its_words(
    language: str, part: int, text: str, check: str, severity: str, at: list[str]
) -> None:
    findings = {finding.check: finding for finding in checker(language).findings(text, part)}
    assert check in findings
    finding = findings[check]
    assert finding.severity == severity
    assert [text[start:end] for start, end in finding.marks] == at


def test_a_good_text_has_no_findings_and_joiners_are_mended() -> None:
    assert checker().findings(GOOD, 0) == ()
    with_joiner = "सीधे चलें और सड़क पर पक्\u200dका रखा धारीदार लाल मग उठा लें।"
    assert [finding.check for finding in checker("hi").findings(with_joiner, 0)] == ["normalisation"]
    assert checker("hi").findings(stored_form(with_joiner, "hi"), 0) == ()


def test_blocking_findings_come_first_and_a_long_text_is_not_examined_further() -> None:
    found = checker().findings("Walk on, (time", 0)
    assert [finding.severity for finding in found] == sorted(
        (f.severity for f in found), key=[BLOCKED, SUSPICIOUS].index
    )
    long = checker(most=60).findings(GOOD, 0)
    assert [(finding.check, finding.expected) for finding in long] == [("too_long", "60")]
    assert any_blocks(long)
    assert [finding.check for finding in checker().findings("x" * 100_000, 0)] == ["too_long"]


@pytest.mark.parametrize(
    ("text", "check"),
    [
        ("Place the striped red mug to the left of the dotted white bowl.", "other_cell"),
        ("Place the striped red mug next to the dotted green hourglass.", "not_in_room"),
        ("Place the striped red mug next to the dotted blue book.", "two_cells"),
    ],
)
def test_hints_about_the_room_never_block(text: str, check: str) -> None:
    book = PlacedObject(ObjectType("dotted", "blue", "book"), RoomPosition(2, 1, 3))
    episode = replace(tiny.episode("0"), decoys=(*tiny.episode("0").decoys, book))
    one = TextChecker(episode, tiny.SECTION, "en", 1000)
    found = [finding for finding in one.findings(text, 1) if finding.severity == HINT]
    assert [finding.check for finding in found] == [check]
    assert not any_blocks(tuple(found))


@pytest.mark.parametrize(
    "text",
    [
        "Facing the wall with the green dots, place the striped red mug to the left of the dotted white bowl.",
        "Place the striped red mug to the left of the dotted white bowl, a little nearer to you than the bowl.",
        "Place the striped red mug next to the dotted green jar.",
        "Place the striped red mug in the corner, next to the dotted white bowl.",
    ],
)
def test_nothing_is_said_of_a_text_of_which_a_word_is_not_read(text: str) -> None:
    found = checker().findings(text, 1)
    assert [finding.check for finding in found if finding.severity == HINT] == []


@pytest.mark.parametrize(
    ("language", "sides"), [("en", (("left", "right"),)), ("hi", (("बाईं", "दाईं"), ("बाएँ", "दाएँ")))]
)
def test_hints_about_the_room_seldom_come_for_right_texts(language: str, sides: Sequence[tuple[str, str]]) -> None:
    """Paraphrases that led their readers to the cell; a wrong text is such a one with its sides exchanged."""
    episodes = {episode.episode_id: episode for episode in generated_episodes()}
    right = [text for text in paraphrases() if text.language == language and text.assembly_led][:150]
    hinted = {False: 0, True: 0}
    for paraphrase, is_wrong in product(right, (False, True)):
        one = TextChecker(episodes[paraphrase.episode], tiny.SECTION, language, 1000)
        said = exchanged(paraphrase.assembly, sides) if is_wrong else paraphrase.assembly
        hinted[is_wrong] += any(finding.severity == HINT for finding in one.findings(said, 2 * paraphrase.turn - 1))
    assert hinted[False] <= len(right) // 20
    assert hinted[True] > hinted[False]


def exchanged(text: str, sides: Sequence[tuple[str, str]]) -> str:
    """Return a text with the words of each pair exchanged."""
    other = {one: two for pair in sides for one, two in (pair, pair[::-1])}
    return re.sub("|".join(other), lambda found: other[found[0]], text)


def test_things_that_are_not_in_the_street_are_hinted_at() -> None:
    found = checker().findings("Walk past the orange cone on your left and pick up the striped red mug.", 0)
    assert [(finding.check, finding.severity, finding.expected) for finding in found] == [("not_there", HINT, "cone")]


def test_nothing_is_said_of_things_of_which_the_reader_of_texts_is_not_sure() -> None:
    pick_up = "and pick up the striped red mug."
    assert checker().findings(f"Walk past the blue bank on your left {pick_up}", 0) == ()
    section = replace(tiny.SECTION, props=(*tiny.SECTION.props, Prop("cone", 2.0, 30.0, 0.0)))
    one = TextChecker(tiny.episode("0"), section, "en", 1000)
    assert one.findings(f"Walk past the orange cone on your left {pick_up}", 0) == (), "one stands farther on"


def test_free_texts_of_people_pass() -> None:
    """Texts that lead to the target are rarely called unclear: few hints on free texts."""
    section = paraphrased_section()
    hints, texts = 0, 0
    for episode in paraphrased_episodes()[:12]:
        for language in ("en", "hi"):
            one = TextChecker(episode, section, language, 1000)
            for part, (turn, phase) in enumerate(
                ((1, "navigation"), (1, "assembly"), (2, "navigation"), (2, "assembly"))
            ):
                found = one.findings(episode.instruction(language, turn, phase), part)
                hints += any(finding.severity == HINT for finding in found)
                texts += 1
    assert (texts, hints < texts / 3) == (96, True)


@pytest.mark.parametrize(
    ("typed", "stored"),
    [("  a\n b\t", "a b"), ("e\u0301", "\u00e9"), ("\u0928\u093c", "\u0929")],
    ids=["spaces", "Latin", "Hindi"],
)
def test_stored_form(typed: str, stored: str) -> None:
    assert stored_form(typed, "hi") == stored


QUALITY = """
single_letters = []
repeats = []
[general]
key = ["klavo"]
[navigation]
[assembly]
tile = ["kahelo"]
[wanted]
turn = ["turnu*"]
pick_up = ["prenu"]
place = ["metu"]
[suspicious]
movement = []
interface = ["blua linio"]
grey_building = []
earlier = []
[counts]
numbers = []
units = []
[landmarks]
words = ["muro"]
[registers]
[misspelt]
"""


def test_a_language_without_grammar_is_checked_by_its_quality_file_alone(tmp_path: Path) -> None:
    folder = tmp_path / "eo"
    folder.mkdir()
    for name in ("language", "lexicon", "relations"):
        (folder / f"{name}.toml").write_text(FILES[name])
    (folder / "quality.toml").write_text(QUALITY)
    one = replace(checker("eo"), root=tmp_path)
    for text, part, checks in (
        ("Iru rekte al la alta muro kaj prenu la strian ruĝan tason.", 0, []),
        ("Iru laŭ la blua linio kaj prenu la strian ruĝan tason.", 0, ["interface"]),
        ("Premu la klavo, iru rekte kaj prenu la strian ruĝan tason.", 0, ["term"]),
        ("Metu la strian ruĝan tason apud la alta muro.", 1, []),
        ("Metu la strian ruĝan tason sur la kahelo apud muro.", 1, ["term"]),
    ):
        assert [finding.check for finding in one.findings(text, part)] == checks, text

"""Habits of voices, preferences among drafts, and wordings of two steps or two things in one clause."""

import re
from pathlib import Path
from random import Random

import pytest

from arramon_lang import load
from arramon_lang.files import read_file
from arramon_lang.language import ROOT
from arramon_lang.meaning import Assembly, Face, Navigation, Rotate, Step, Thing, Walk, Where
from arramon_lang.writing.preferences import Preferences, reduced
from arramon_lang.writing.voice import MANNERS, Voice, draw_voice
from arramon_lang.writing.writer import Writer

MUG = Thing("mug", "red", "striped", identity="9")
BENCH, CONE = Thing("bench", identity="1"), Thing("cone", "red", identity="2")
ENGLISH = load("en")


def written(*steps: Step, target: Thing = MUG, count: int = 60) -> list[str]:
    return [ENGLISH.write(Navigation(steps, target), Random(seed)) for seed in range(count)]


@pytest.mark.parametrize(
    ("steps", "said"),
    [
        ((Rotate("left"), Face(CONE)), r"^turn (\w+ )*left to face (the|a) red [\w ]*cone"),
        ((Walk("past", (BENCH,)), Walk("past", (CONE,))), r"past (the|a) [\w ]*(bench|seat) and (the )?red [\w ]*cone"),
        ((Walk("to", (CONE,)),), r"until you (reach|get to|come to|find|hit) a red [\w ]*cone"),
    ],
)
def test_steps_that_people_join(steps: tuple[Step, ...], said: str) -> None:
    texts = written(*steps)
    assert any(re.search(said, text, re.IGNORECASE) for text in texts)
    assert all(ENGLISH.read(text, "navigation") == Navigation(steps, MUG) for text in texts)


def test_two_landmarks_of_a_target_are_named_together() -> None:
    target = Thing("mug", "red", "striped", where=(Where("near", (BENCH,)), Where("near", (CONE,))))
    texts = written(Rotate("left"), target=target)
    assert any(re.search(r"(near|by|next to) the [\w ]+ and (the )?red", text) for text in texts)
    assert all(ENGLISH.read(text, "navigation").target == target for text in texts)  # type: ignore[union-attr]


def test_a_thing_is_new_only_once() -> None:
    texts = written(Walk("past", (CONE,)), Walk("to", (BENCH,)), Walk("to", (CONE,)))
    assert not any(re.search(r"\ba red [\w ]*cone.*\ba red [\w ]*cone", text) for text in texts)
    assert not any(re.search(r"\ba second\b", text) for text in written(Walk("to", (Thing("bench", which="second"),))))


def _voice(**habits: object) -> Voice:
    for seed in range(400):
        voice = draw_voice(ENGLISH.grammar, Random(seed))
        if all(getattr(voice, name) == value for name, value in habits.items()):
            return voice
    raise AssertionError(habits)


def test_a_voice_keeps_its_punctuation_and_case() -> None:
    voice = _voice(end="", has_capitals=False)
    for seed in range(20):
        text = ENGLISH.write(Navigation((Rotate("left"), Walk("to", (CONE,))), MUG), Random(seed), voice)
        assert text[-1] not in ".,;"
        assert text == text.lower()


def test_a_voice_without_articles_is_read_like_others() -> None:
    target = Thing("mug", "red", "striped", where=(Where("left_of", (BENCH,)),))
    end = Thing("street_end", identity="street_end")
    placed = Thing("mug", "blue", "dotted", where=(Where("right_of", (Thing("ball"),)),))
    voice = _voice(has_articles=False)
    for meaning, phase in (
        (
            Navigation((Rotate("right"), Walk("to", (end,)), Rotate("left"), Walk("past", (CONE,))), target),
            "navigation",
        ),
        (Assembly(("left",), MUG, (Where("on_top_of", (placed,)),)), "assembly"),
    ):
        texts = [ENGLISH.write(meaning, Random(seed), voice) for seed in range(40)]
        assert not [text for text in texts if re.search(r"\bthe\b", text, re.IGNORECASE)]
        assert not [text for text in texts if voice.has_capitals and text[0].islower()]
        assert not [text for text in texts if ENGLISH.read(text, phase) != meaning]


def test_two_walls_share_their_noun() -> None:
    walls = tuple(Where("against", (Thing("wall", look=look),)) for look in ("brick", "wood"))
    meaning = Assembly((), MUG, walls)
    texts = [ENGLISH.write(meaning, Random(seed)) for seed in range(60)]
    assert any(re.search(r"the brick and wood\w* walls", text) for text in texts)
    assert not [text for text in texts if ENGLISH.read(text, "assembly") != meaning]


def test_a_voice_has_a_verb_of_its_own() -> None:
    voice = _voice(end=".")
    verb = voice.favourites["grab"].form({})
    writer = Writer(ENGLISH.grammar)
    meanings = [Navigation((Rotate("left"),), MUG)] * 60
    texts = [writer.write(each, Random(seed), voice).casefold() for seed, each in enumerate(meanings)]
    assert sum(str(verb).split()[0] in text for text in texts) > 36
    assert str(voice.favourites["grab_it"].form({})).split()[0] == str(verb).split()[0]


def test_manners_differ_in_length() -> None:
    meaning = Navigation((Rotate("left"), Walk("past", (CONE,)), Walk("to", (BENCH,))), MUG)
    sizes = {}
    for manner in (each for each in MANNERS if each.name in ("terse", "thorough")):
        voices = [draw_voice(ENGLISH.grammar, Random(seed), manner) for seed in range(60)]
        texts = [ENGLISH.write(meaning, Random(seed), voice) for seed, voice in enumerate(voices)]
        sizes[manner.name] = sum(len(text.split()) for text in texts)
    assert sizes["terse"] < sizes["thorough"]


def test_preferences_sum_the_weights_of_word_sequences() -> None:
    preferences = Preferences({"navigation": {"then": -2.0, "until you see": 1.5, "_ >": 0.25, "< turn": 0.5}})
    assert preferences.score("Turn left until you see a cone", "navigation") == 2.25
    assert preferences.score("Then go, then stop.", "navigation") == -1.75
    assert preferences.score("Then go", "assembly") == 0.0


def test_words_that_are_not_kept_become_one_mark() -> None:
    assert reduced("Go past the red cone, then stop", {"past", "the", "then", ","}) == [
        *("<", "_", "past", "the", "_", ",", "then", "_", ">"),
    ]


def test_drafts_are_drawn_by_preferences() -> None:
    writer = Writer(ENGLISH.grammar, Preferences({"navigation": {"then": -50.0, "and": 5.0}}))
    meaning = Navigation((Rotate("left"), Walk("to", (CONE,))), MUG)
    texts = [writer.write(meaning, Random(seed)).casefold() for seed in range(40)]
    assert not any(re.search(r"\bthen\b", text) for text in texts)


def test_the_file_of_preferences_has_short_sequences_alone() -> None:
    data = read_file(Path(ROOT) / "en", "preferences")
    keys = [key for phase in ("navigation", "assembly") for key in data[phase]]
    assert keys
    assert max(len(key.split()) for key in keys) <= 3
    names = {"cone", "bench"} | {
        word for nouns in ENGLISH.grammar.nouns.values() for noun in nouns for _, word in noun.forms
    }
    assert not (names - {"wall", "walls"}) & {word for key in keys for word in key.split()}

"""The paraphrased split as it is shipped: complete, in both languages, and divided into halves."""

import unicodedata
from collections import Counter
from pathlib import Path

import arramon_lang as lang
from arramon_dataset.paraphrases.collection import (
    HALVES,
    NAME,
    generated_episodes,
    paraphrased_episodes,
    paraphrased_section,
    paraphrases,
)
from arramon_server.cli import main
from arramon_server.episodes.splits import read_splits


def test_every_turn_of_300_episodes_has_texts_in_both_languages() -> None:
    ids = {episode.episode_id for episode in generated_episodes()}
    assert len(ids) >= 300
    expected = {(episode, turn, language) for episode in ids for turn in (1, 2) for language in ("en", "hi")}
    assert Counter((text.episode, text.turn, text.language) for text in paraphrases()) == Counter(expected)


def test_no_text_is_that_of_the_grammar() -> None:
    generated = {episode.episode_id: episode for episode in generated_episodes()}
    for text in paraphrases():
        written = generated[text.episode].instructions[text.language][text.turn - 1]
        assert text.navigation != written.navigation
        assert text.assembly != written.assembly


def test_texts_are_in_their_language_and_normalised() -> None:
    for text in paraphrases():
        for words in (text.navigation, text.assembly):
            assert lang.identify(words) == text.language
            assert unicodedata.is_normalized("NFC", words)


def test_an_episode_is_in_one_half_and_every_writer_in_both() -> None:
    halves = {(text.episode, text.half) for text in paraphrases()}
    assert len(halves) == len(generated_episodes())
    for writer in {text.writer for text in paraphrases()}:
        assert {text.half for text in paraphrases() if text.writer == writer} == set(HALVES)


def test_the_command_adds_the_split(tmp_path: Path) -> None:
    assert main(["add-paraphrased", "--data", str(tmp_path)]) == 0
    split = read_splits(tmp_path)[NAME]
    assert split.languages == {"en": 312, "hi": 312}
    assert list(split.episodes.values()) == paraphrased_episodes()
    assert list(split.sections.values()) == [paraphrased_section()]

"""Training task of the reader: overfitting a few texts, and scores."""

from pathlib import Path

import pytest
import torch

from arramon_agents.reading.reader.network import ReaderNetwork, ReaderSizes
from arramon_agents.reading.reader.reader import load, write_reader
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.reading.reader.task import (
    HASTY_SHARE,
    SPELLED_SHARE,
    TYPING_ERRORS,
    UNKNOWN_SHARE,
    Examples,
    ReadingTask,
    score,
)
from arramon_agents.reading.reader.vocabulary import UNKNOWN, Vocabulary, split
from arramon_agents.training.schedule import warm_up_cosine
from arramon_agents.training.trainer import Trainer, TrainerSettings
from arramon_agents.weights import BadWeights
from arramon_lang.meaning import Meaning, Navigation, Rotate, Thing, Walk

MUG, BALL = Thing("mug", "red", "dotted"), Thing("ball", "blue", "striped")

TEXTS: list[tuple[str, str, Meaning]] = [
    ("en", "turn left and pick up the dotted red mug", Navigation((Rotate("left"),), MUG)),
    ("en", "go past the bench and get the striped blue ball", Navigation((Walk("past", (Thing("bench"),)),), BALL)),
    ("hi", "बाएँ मुड़ें और बिंदीदार लाल मग उठाएँ", Navigation((Rotate("left"),), MUG)),
    ("hi", "बेंच के आगे जाएँ और धारीदार नीली गेंद उठाएँ", Navigation((Walk("past", (Thing("bench"),)),), BALL)),
]


def examples(vocabulary: Vocabulary) -> Examples:
    return Examples.of(
        [split(text) for _, text, _ in TEXTS],
        [rows_of(meaning) for _, _, meaning in TEXTS],
        [language for language, _, _ in TEXTS],
        vocabulary,
    )


def test_texts_are_learned_in_both_languages_and_read_from_a_file(tmp_path: Path) -> None:
    vocabulary = Vocabulary.of([text for _, text, _ in TEXTS], fewest=1)
    given = examples(vocabulary)
    torch.manual_seed(0)
    network = ReaderNetwork(ReaderSizes(len(vocabulary), 16, 16, 32, dropout=0.0))
    before = score(network, given)
    assert before["en"].texts == before["hi"].texts == 0.0
    settings = TrainerSettings("reader", steps=200, rate=warm_up_cosine(0.01, 200), seed=0)
    Trainer(ReadingTask(network, given, batch=4, seed=0), settings).run()
    after = score(network, given)
    assert {language: (one.rows, one.texts, one.count) for language, one in after.items()} == {
        "en": (1.0, 1.0, 2),
        "hi": (1.0, 1.0, 2),
    }
    write_reader(tmp_path / "reader.safetensors", network, vocabulary)
    reader = load(tmp_path / "reader.safetensors")
    for _, text, meaning in TEXTS:
        assert reader.read(text, "navigation") == meaning


def test_a_missing_reader_is_named(tmp_path: Path) -> None:
    with pytest.raises(BadWeights, match="there are no weights of the learned reader"):
        load(tmp_path / "none.safetensors")


def test_texts_are_learned_with_typing_errors_and_unknown_words_in_them() -> None:
    torch.manual_seed(2)
    vocabulary = Vocabulary.of([text for _, text, _ in TEXTS], fewest=1)
    given = examples(vocabulary)
    task = ReadingTask(ReaderNetwork(ReaderSizes(len(vocabulary), 8, 8, 16)), given, batch=4, seed=0)
    texts = given.texts.repeat(500, 1)
    noisy, right, is_word = task._noisy(texts), given.codes[texts], texts != 0
    assert not noisy[~is_word].any()
    has_letters = noisy[..., 1:].any(2)[is_word]
    same_letters = (noisy[..., 1:] == right[..., 1:]).all(2)[is_word]
    known = noisy[..., 0][is_word] != UNKNOWN
    assert (noisy[..., 0] == right[..., 0])[is_word][known].all()
    assert float((~has_letters).float().mean()) == pytest.approx(UNKNOWN_SHARE, abs=0.01)
    assert float((has_letters & ~same_letters).float().mean()) == pytest.approx(HASTY_SHARE * TYPING_ERRORS, abs=0.02)
    assert float((~known & same_letters).float().mean()) == pytest.approx(SPELLED_SHARE, abs=0.02)

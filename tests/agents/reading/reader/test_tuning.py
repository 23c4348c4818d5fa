"""Fine-tuning of the reader on people's texts: halves, added words, progress."""

from pathlib import Path

import pytest
import torch

from arramon_agents.reading.reader.network import ReaderNetwork, ReaderSizes
from arramon_agents.reading.reader.reader import load, write_reader
from arramon_agents.reading.reader.recipe import TuningRecipe
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.reading.reader.train import extend_vocabulary, tune
from arramon_agents.reading.reader.words import Vocabulary
from arramon_agents.simulated.people import halves, read_half, read_people
from tests import tiny
from tests.agents.training_fixtures import place


def test_the_halves_share_no_episode(tmp_path: Path) -> None:
    split = tiny.write(tmp_path, "val_seen", 6)
    learned, tested = halves(split, "en")
    assert len(learned) == len(tested) == 3
    assert {one.episode_id for one in learned}.isdisjoint(one.episode_id for one in tested)
    assert len(read_people(learned, "en")) == 12
    assert read_half(tmp_path, "val_seen", "en") == read_people(learned, "en")


def test_a_wider_network_reads_as_before() -> None:
    torch.manual_seed(0)
    known, vocabulary = Vocabulary(["left", "turn"]), Vocabulary(["left", "turn", "sinistral"])
    network = ReaderNetwork(ReaderSizes(len(known), 8, 8, 16)).eval()
    wider = extend_vocabulary(network, known, vocabulary).eval()
    texts = torch.tensor([vocabulary.numbers("turn left")])
    assert torch.equal(wider.read(texts), network.read(texts))
    unknown = torch.tensor([known.numbers("turn sinistral")])
    assert torch.equal(wider.read(torch.tensor([vocabulary.numbers("turn sinistral")])), network.read(unknown))


def test_peoples_texts_are_learned(tmp_path: Path) -> None:
    torch.manual_seed(0)
    torch.set_num_threads(1)
    known = Vocabulary(["go", "on", "to", "the"])
    write_reader(tmp_path / "start.safetensors", ReaderNetwork(ReaderSizes(len(known), 16, 16, 32, dropout=0.0)), known)
    learned, _ = halves(tiny.write(tmp_path, "val_seen", 6), "en")
    samples = read_people(learned, "en")
    tuning = TuningRecipe(init=str(tmp_path / "start.safetensors"), passes=300, learning_rate=0.01)
    weights = tune(tuning, samples, ("en",), place(tmp_path / "out"))
    assert rows_of(load(weights).read(samples[0].text, "navigation")) == rows_of(samples[0].meaning)


def test_people_write_in_one_language() -> None:
    with pytest.raises(ValueError, match="languages en,hi: expected one language of people's texts"):
        TuningRecipe(("en", "hi"))

"""Fine-tuning of the reader on people's texts: halves, added words, progress."""

from pathlib import Path

import pytest
import torch

from arramon_agents.reading.reader.network import ReaderNetwork, ReaderSizes
from arramon_agents.reading.reader.reader import load, write_reader
from arramon_agents.reading.reader.recipe import FineTuningRecipe
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.reading.reader.train import extend_vocabulary, fine_tune
from arramon_agents.reading.reader.vocabulary import Vocabulary
from arramon_agents.simulated.people_texts import halves, parse_people_texts, parse_training_half
from tests import tiny
from tests.agents.training_fixtures import place


def test_the_halves_share_no_episode(tmp_path: Path) -> None:
    split = tiny.write(tmp_path, "val_seen", 6)
    learned, tested = halves(split, "en")
    assert len(learned) == len(tested) == 3
    assert {one.episode_id for one in learned}.isdisjoint(one.episode_id for one in tested)
    assert len(parse_people_texts(learned, "en")) == 12
    assert parse_training_half(tmp_path, "val_seen", "en") == parse_people_texts(learned, "en")


def test_a_wider_network_reads_as_before() -> None:
    torch.manual_seed(0)
    known, vocabulary = Vocabulary(["left", "turn"]), Vocabulary(["left", "turn", "sinistral"])
    network = ReaderNetwork(ReaderSizes(len(known), 8, 8, 16)).eval()
    wider = extend_vocabulary(network, known, vocabulary).eval()
    texts = torch.tensor([vocabulary.encode("turn left")])
    assert torch.equal(wider.read(texts), network.read(texts))
    unknown = torch.tensor([known.encode("turn sinistral")])
    assert torch.equal(wider.read(torch.tensor([vocabulary.encode("turn sinistral")])), network.read(unknown))


def test_peoples_texts_are_learned(tmp_path: Path) -> None:
    torch.manual_seed(0)
    torch.set_num_threads(1)
    known = Vocabulary(["go", "on", "to", "the"])
    write_reader(tmp_path / "start.safetensors", ReaderNetwork(ReaderSizes(len(known), 16, 16, 32, dropout=0.0)), known)
    learned, _ = halves(tiny.write(tmp_path, "val_seen", 6), "en")
    samples = parse_people_texts(learned, "en")
    tuning = FineTuningRecipe(init=str(tmp_path / "start.safetensors"), passes=300, learning_rate=0.01)
    weights = fine_tune(tuning, samples, ("en",), place(tmp_path / "out"))
    assert rows_of(load(weights).read(samples[0].text, "navigation")) == rows_of(samples[0].meaning)


def test_people_write_in_one_language() -> None:
    with pytest.raises(ValueError, match="languages en,hi: expected one language of people's texts"):
        FineTuningRecipe(("en", "hi"))

"""Training data of a recipe."""

from dataclasses import replace
from pathlib import Path

from arramon_agents.training.demonstrations import ROOMS, DemonstrationSource
from arramon_agents.training.sources import load_demonstrations, sources_of, splits_of
from tests import tiny
from tests.agents.training_fixtures import place


def test_streets_drawn_for_training_are_learned_from_if_they_are_there(tmp_path: Path) -> None:
    tiny.write(tmp_path, "train")
    tiny.write(tmp_path, "val_seen")
    train = DemonstrationSource(tmp_path, "train", ("en", "hi"), "pooled", 2, every=2)
    assert [source.split for source in sources_of(train, 3)] == ["train", ROOMS]
    tiny.write(tmp_path, "train_extra", training=True)
    assert [source.split for source in sources_of(train, 3)] == ["train", "train_extra", ROOMS]
    assert [source.episodes for source in sources_of(train, 3)] == [2, 2, 3]
    assert sources_of(train, 0) == [train, replace(train, split="train_extra")]
    assert sources_of(replace(train, split="val_seen"), 0) == [replace(train, split="val_seen")]
    assert splits_of("train", tmp_path) == ["train", "train_extra"]
    assert splits_of("val_seen", tmp_path) == ["val_seen"]
    found = list(load_demonstrations(sources_of(train, 0), place(tmp_path, tmp_path), print))
    assert len(found) == 2 * 2 * 4  # Splits, episodes, and in each two turns of two phases.

"""Scores of the encoder's predictions on synthetic frames."""

import numpy as np
import pytest

from arramon_agents.perception.eyes.grid import CHANNEL_NAMES
from arramon_agents.perception.eyes.scores import GridScores, NameScores
from tests.agents.perception.eyes.test_grid import named

LABELS = [("road", "", ""), ("mug", "blue", "dotted"), ("cone", "red", "")]


def test_cells_are_counted_by_channel() -> None:
    segmentation = np.zeros((224, 224), np.uint16)
    segmentation[0:4, 0:4] = 1  # 16 pixels of the first cell: just enough.
    segmentation[0:3, 32:37] = 1  # 15 of the second.
    features = np.zeros((7, 7, len(CHANNEL_NAMES)), np.float32)
    features[0, 1, CHANNEL_NAMES.index("kind:mug")] = 0.6
    features[0, 0, CHANNEL_NAMES.index("colour:blue")] = 0.6
    scores = GridScores(LABELS)
    scores.add(features, segmentation)
    mug, blue = scores.counts["kind:mug"], scores.counts["colour:blue"]
    assert (mug.hits, mug.false, mug.missed, mug.f1) == (0, 1, 1, 0.0)
    assert (blue.hits, blue.false, blue.missed, blue.f1) == (1, 0, 0, 1.0)
    assert scores.counts["ground"].missed == 49
    assert scores.groups()["colour"] == 1.0


def test_names_are_counted_by_size() -> None:
    segmentation = np.zeros((224, 224), np.uint16)
    segmentation[100:110, 40:50] = 1
    segmentation[150:160, 40:50] = 2
    things = [
        named("mug", "blue", "striped", slice(100, 110), slice(40, 50)),
        named("ball", "red", "dotted", slice(150, 160), slice(40, 50)),
    ]
    scores = NameScores(LABELS)
    scores.add(things, segmentation)
    scores.add([], segmentation)
    assert scores.false == 1
    (row,) = scores.shares().values()
    assert row == pytest.approx({"count": 2, "found": 0.5, "kind": 0.5, "colour": 0.5, "pattern": 0.0, "all": 0.0})

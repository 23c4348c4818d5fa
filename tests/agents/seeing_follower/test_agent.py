"""The follower with learned perception and reader, with the shipped weights."""

from dataclasses import replace
from random import Random

import numpy as np
import pytest

import arramon_lang as lang
from arramon_agents.perception.eyes.encoder import load_far
from arramon_agents.perception.eyes.predicted_segmentation import LABELS, predict_percepts
from arramon_agents.perception.eyes.vocabulary import LOOK_GROUPS
from arramon_agents.reading.reader.reader import LearnedReader, load
from arramon_agents.seeing_follower import Agent
from arramon_agents.simulated.frames import FrameSource, label_names
from arramon_client.agent import Episode, Observation
from arramon_client.world import COLLECTIBLE_COLOURS, COLLECTIBLES
from arramon_lang.meaning import Navigation, Rotate, Thing, Walk

TEXTS = 25
PATTERNS = LOOK_GROUPS[0].looks


class Said(LearnedReader):
    """Reads every instruction as the same meaning."""

    def __init__(self, meaning: Navigation) -> None:
        self._meaning = meaning

    def read(self, text: str, phase: str) -> Navigation:
        return self._meaning


@pytest.mark.parametrize("language", ["en", "hi"])
def test_the_reader_that_comes_along_knows_what_to_pick_up(language: str) -> None:
    """It is not told the language. Far from all texts are read without a fault, most targets are."""
    reader, right = load(), 0
    for seed in range(TEXTS):
        random = Random(seed)
        target = Thing(random.choice(COLLECTIBLES), random.choice(COLLECTIBLE_COLOURS), random.choice(PATTERNS))
        meaning = Navigation((Rotate(random.choice(("left", "right"))), Walk("to", (Thing("bench"),))), target)
        read = reader.read(lang.load(language).write(meaning, random), "navigation")
        assert isinstance(read, Navigation)
        right += replace(read.target, where=()) == target and read.steps[:1] == meaning.steps[:1]
    assert right >= 0.8 * TEXTS


def test_it_picks_up_what_is_named_by_rgb_and_depth_alone() -> None:
    """In a frame in which one collectible lies straight ahead, within reach."""
    source, eyes = FrameSource([("6", "0")], 224, 11, room_share=0.0), load_far()
    picked = 0
    for number in range(400):
        frame = source.frame(number)
        names = [label_names()[label] for label in np.unique(frame.labels)]
        lying = [name for name in names if name[0] in COLLECTIBLES]
        if len(lying) != 1:
            continue
        shown = frame.depth[frame.labels == label_names().index(lying[0])]
        columns = np.nonzero(frame.labels == label_names().index(lying[0]))[1]
        if not 1.0 < shown.mean() < 1.6 or abs(columns.mean() - 112) > 25:
            continue
        agent = Agent(eyes, Said(Navigation((), Thing(*lying[0]))))
        agent.begin(Episode("one", "en", "trial"))
        assert agent.act([Observation("one", 1, "navigation", 0, "", 0, 150, rgb=frame.rgb, depth=frame.depth)]) == [3]
        picked += 1
        if picked == 3:
            break
    assert picked == 3


def test_missing_sensors_are_named() -> None:
    agent = Agent()
    agent.begin(Episode("one", "en", "trial"))
    with pytest.raises(ValueError, match="requires the sensors rgb and depth"):
        agent.act([Observation("one", 1, "navigation", 0, "Turn left and take the red mug.", 0, 150)])


def test_upright_pixels_are_no_road() -> None:
    source, eyes = FrameSource([("6", "0")], 224, 12, room_share=0.0), load_far()
    right = total = 0
    for number in range(6):
        frame = source.frame(number)
        seen = predict_percepts(eyes, frame.rgb[None], frame.depth[None])[0].labels
        kinds = np.array([label.kind for label in LABELS])[seen]
        truth = np.array([name[0] for name in label_names()])[frame.labels]
        building = truth == "building"
        right += int((kinds[building] == "building").sum())
        total += int(building.sum())
    assert right > 0.85 * total

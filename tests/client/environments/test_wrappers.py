"""Wrappers."""

from pathlib import Path

import gymnasium
import numpy as np
import pytest

from arramon_client.environments import BadArgument
from arramon_client.environments.wrappers import StartFrame
from tests import tiny

POSES = [
    (0, 0, 0), (0, 1, 0), (0, 2, 0),  # the first street
    (0, 0, 0), (0, 1, 0),  # the room
    (0, 0, 0), (0, 0, 30), (0, 0, 60), (0, 0, 90), (1, 0, 90), (2, 0, 90),  # the second street
    (0, 0, 0), (0, 1, 0),
]  # fmt: skip


def test_poses_from_the_start_of_each_phase(data: Path) -> None:
    inner = gymnasium.make("arramon/ArraMon-v0", data=data, split="tiny", sensors=("pose",))
    env = StartFrame(inner)
    values, _ = env.reset(options={"episode": "1"})
    seen = [values["pose"]]
    for action in tiny.ACTIONS[:-1]:
        values, *_ = env.step(np.int64(action))
        assert env.observation_space.contains(values)
        seen.append(values["pose"])
    assert np.array(seen) == pytest.approx(np.array(POSES, float), abs=1e-9)


def test_it_needs_the_pose(data: Path) -> None:
    with pytest.raises(BadArgument, match="StartFrame needs the sensor 'pose'"):
        StartFrame(gymnasium.make("arramon/ArraMon-v0", data=data, split="tiny", sensors=()))


def test_it_needs_to_know_the_phase(data: Path) -> None:
    with pytest.raises(BadArgument, match=r"needs the key 'phase' in the observation: add it to observe="):
        StartFrame(gymnasium.make("arramon/ArraMon-v0", data=data, split="tiny", observe=("pose", "turn")))

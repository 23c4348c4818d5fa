"""The vector environment: the same as single ones, whole texts, arrays that stay as they are, autoreset modes."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv

from arramon_client.environments import BadArgument
from arramon_client.environments.backend import Images
from arramon_client.environments.vector import ArraMonVectorEnv
from arramon_client.environments.worker import WorkerDied
from arramon_dataset.environments.player import LocalPlayer

ID = "arramon/ArraMon-v0"
COUNT = 3


def options(data: Path) -> dict[str, Any]:
    return {"data": data, "split": "tiny", "image_size": 16, "steps_per_phase": 3}


@pytest.fixture(params=[1, 2, 3])
def processes(request: pytest.FixtureRequest) -> int:
    return int(request.param)


def made(data: Path, processes: int = 1, mode: str = "NextStep", **more: Any) -> ArraMonVectorEnv:
    env = gymnasium.make_vec(ID, COUNT, processes=processes, autoreset_mode=mode, **{**options(data), **more})
    assert isinstance(env, ArraMonVectorEnv)
    return env


def actions(steps: int) -> Iterator[Any]:
    random = np.random.default_rng(5)
    for _ in range(steps):
        yield random.integers(4, size=COUNT)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_it_is_what_gymnasium_makes_of_single_ones(data: Path, processes: int, mode: str) -> None:
    """Observations, rewards, ends and infos, through several ends of episodes."""
    ours = made(data, processes, mode, lang="hi", reward="progress")
    theirs = SyncVectorEnv(
        [lambda: gymnasium.make(ID, lang="hi", reward="progress", **options(data)) for _ in range(COUNT)],
        autoreset_mode=AutoresetMode(mode),
    )
    assert ours.metadata["autoreset_mode"] is AutoresetMode(mode)
    assert ours.single_observation_space == theirs.single_observation_space
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    assert data_equivalence(ours.reset(seed=4), theirs.reset(seed=4), exact=True)
    ends = 0
    for chosen in actions(40):
        one, other = ours.step(chosen), theirs.step(chosen)
        assert ours.observation_space.contains(one[0])
        for mine, its in zip(one, other, strict=True):
            assert data_equivalence(mine, its, exact=True)
        ends += int(one[2].sum())
    assert ends > 6
    ours.close()
    theirs.close()


def test_disabled_resets_those_of_the_mask(data: Path, processes: int) -> None:
    env = made(data, processes, "Disabled")
    before, _ = env.reset(seed=1, options={"episode": ["0", "1", "2"]})
    while True:
        values, _, terminated, _, infos = env.step(np.array([1, 2, 1]))
        if terminated.any():
            break
    assert terminated.all()
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(COUNT, int))
    again, infos = env.reset(options={"reset_mask": np.array([False, True, False]), "episode": ["3", "4", "5"]})
    assert infos["episode_id"].tolist() == [None, "4", None]
    assert again["steps_left"][:, 0].tolist() == [values["steps_left"][0, 0], 3, values["steps_left"][2, 0]]
    assert (again["rgb"][0] == values["rgb"][0]).all()
    assert (again["rgb"][1] == before["rgb"][1]).all()  # All tiny episodes begin alike.
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(COUNT, int))
    env.close()


def test_episodes_in_one_place_are_played_one_after_another(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    places: list[str] = []
    original = LocalPlayer.draw

    def draw(self: LocalPlayer, into: Images) -> None:
        places.append(self.place)
        original(self, into)

    monkeypatch.setattr(LocalPlayer, "draw", draw)
    env = made(data, steps_per_phase=4)
    env.reset(options={"episode": "1"})
    orders = []
    for chosen in ([0, 0, 0], [3, 1, 3], [0, 0, 0]):
        places.clear()
        env.step(np.array(chosen))
        orders.append(list(places))
    # The second action of the first and the last one begins their next phase, in the room.
    assert orders == [["1", "1", "1"], ["", "", "1"], ["", "", "1"]]
    env.close()


def test_texts_arrive_whole(data: Path, processes: int) -> None:
    """As they do not through Gymnasium's own processes with its default shared memory, which no check notices."""
    env = made(data, processes, lang="hi")
    values, _ = env.reset(seed=0)
    assert values["instruction"] == ("धारीदार लाल मग तक चलें।",) * COUNT
    for chosen in actions(30):
        before = values["phase"]
        values, *_ = env.step(chosen)
        texts = {0: "धारीदार लाल मग तक चलें।", 1: "उसे दो क़दम आगे रखें।"}
        assert values["instruction"] == tuple(texts[int(phase)] for phase in values["phase"]), before
    env.close()


def test_gymnasiums_own_processes_blank_texts(data: Path) -> None:
    """If this fails, Gymnasium has mended it, and the documentation's warning can go."""
    env = AsyncVectorEnv([lambda: gymnasium.make(ID, lang="en", **options(data))] * 2)
    values, _ = env.reset(seed=0)
    env.close()
    assert set("".join(values["instruction"])) <= {"\0", " "}


def test_what_was_returned_never_changes(data: Path, processes: int) -> None:
    """However many observations a learner keeps; what it keeps none of is used again."""
    env = made(data, processes)
    kept, copies = [], []
    values, _ = env.reset(seed=0)
    for chosen in actions(12):
        kept.append(values["depth"][1])  # A view alone keeps the memory.
        copies.append(values["depth"][1].copy())
        values, *_ = env.step(chosen)
    for one, other in zip(kept, copies, strict=True):
        assert (one == other).all()
    del kept[:-1]
    for chosen in actions(8):
        values, *_ = env.step(chosen)
    assert (kept[0] == copies[-1]).all()
    env.close()


def test_memory_is_used_again_when_nothing_of_it_is_kept(data: Path) -> None:
    env = made(data, 2)
    values, _ = env.reset(seed=0)
    addresses = set()
    for chosen in actions(20):
        addresses.add(values["rgb"].ctypes.data)
        values, *_ = env.step(chosen)
    assert len(addresses) <= 4
    env.close()


@pytest.mark.parametrize("context", ["fork", "spawn"])
def test_contexts(data: Path, context: str) -> None:
    env = made(data, 2, context=context)
    values, _ = env.reset(options={"episode": "1"})
    assert values["instruction"] == ("Go on to the striped red mug.",) * COUNT
    assert (values["rgb"][0] == values["rgb"][2]).all()  # Drawn in two processes.
    env.close()


def test_bad_input_in_any_process(data: Path, processes: int) -> None:
    env = made(data, processes)
    with pytest.raises(BadArgument, match="there is no episode '99'"):
        env.reset(options={"episode": ["0", "1", "99"]})
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(COUNT, int))
    env.reset(seed=0)  # It goes on.
    for wrong in (np.zeros(2, int), np.array([0, 0, 4]), np.array([0.0, 1.0, 1.0]), np.zeros((3, 1), int), np.array(0)):
        with pytest.raises(gymnasium.error.InvalidAction):
            env.step(wrong)
    with pytest.raises(BadArgument, match="there are 2 seeds, expected 3"):
        env.reset(seed=[1, 2])
    with pytest.raises(BadArgument, match="there are 1 episodes, expected 3"):
        env.reset(options={"episode": ["0"]})
    with pytest.raises(BadArgument, match="reset_mask is"):
        env.reset(options={"reset_mask": [True] * 3})
    values, *_ = env.step(np.zeros(COUNT, int))
    assert values["steps_left"][:, 0].tolist() == [2, 2, 2]
    env.close()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"num_envs": 0}, "num_envs is 0"),
        ({"num_envs": 1.5}, r"num_envs is 1\.5, expected at least 1"),
        ({"num_envs": 2, "context": "thread"}, "context is 'thread', expected None, 'fork'"),
        ({"num_envs": 2, "processes": 3}, "processes is 3, expected 1 to num_envs, which is 2"),
        ({"num_envs": 2, "autoreset_mode": "Never"}, "autoreset_mode is 'Never', expected 'NextStep', 'SameStep'"),
        ({"num_envs": 2, "render_mode": "human"}, "render_mode is 'human', expected None or 'rgb_array'"),
    ],
)
def test_wrong_arguments(data: Path, given: dict[str, Any], message: str) -> None:
    with pytest.raises(BadArgument, match=message):
        ArraMonVectorEnv(**given, **options(data))


def test_a_process_that_dies_is_an_error(data: Path) -> None:
    env = made(data, 2)
    env.reset(seed=0)
    os.kill(env.process_ids[0], signal.SIGKILL)
    with pytest.raises(WorkerDied, match="ended with status -9"):
        env.step(np.zeros(COUNT, int))
    env.close()


def test_pictures(data: Path, processes: int) -> None:
    """Of all episodes, whichever process plays them."""
    env = made(data, processes, "Disabled", render_mode="rgb_array", lang="hi")
    assert env.metadata["render_modes"] == ["rgb_array"]
    with pytest.raises(gymnasium.error.ResetNeeded, match="no episode has begun"):
        env.render()
    env.reset(options={"episode": ["1", "2", "4"]})
    env.step(np.array([0, 1, 2]))
    pictures = env.render()
    assert isinstance(pictures, tuple)
    for number, (episode, picture) in enumerate(zip(("1", "2", "4"), pictures, strict=True)):
        single: Any = gymnasium.make(ID, render_mode="rgb_array", lang="hi", **options(data))
        single.reset(options={"episode": episode})
        single.step(number)
        assert (picture == single.render()).all()
    env.close()
    assert made(data, processes).render() is None


def test_the_room_alone() -> None:
    env: Any = gymnasium.make_vec("arramon/ArraMonRoom-v0", 2, sensors=("segmentation",), image_size=16, lang="hi")
    values, infos = env.reset(seed=0)
    assert values["phase"].tolist() == [1, 1]
    assert all(each.startswith("room-") for each in infos["episode_id"])
    assert env.observation_space.contains(values)
    env.close()

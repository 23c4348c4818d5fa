"""Environments that are pickled and copied: what comes after is the same, at any step."""

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cloudpickle
import gymnasium
import numpy as np
import pytest

from arramon_client.environments import WordTokenizer
from arramon_client.environments.errors import CannotCopy
from arramon_client.environments.two_agents import env, parallel_env, raw_env
from arramon_client.environments.wrappers import StartFrame
from tests import tiny

Copy = Callable[[Any], Any]

COPIES: dict[str, Copy] = {
    "pickle": lambda made: pickle.loads(pickle.dumps(made)),
    "cloudpickle": lambda made: pickle.loads(cloudpickle.dumps(made)),
    "deepcopy": copy.deepcopy,
}

each_way = pytest.mark.parametrize("way", COPIES.values(), ids=COPIES)


def make(data: Path, **options: Any) -> gymnasium.Env[Any, Any]:
    given = {"data": data, "split": "tiny", "image_size": 16, "sensors": ("rgb", "depth", "segmentation", "pose")}
    return gymnasium.make("arramon/ArraMon-v0", **{**given, "reward": "progress", **options})


def same(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(same, one, other))
    return np.array_equal(one, other) and getattr(one, "dtype", None) == getattr(other, "dtype", None)


def played(made: gymnasium.Env[Any, Any], actions: list[int]) -> list[Any]:
    """What follows some actions, and two further episodes that are drawn."""
    found: list[Any] = [made.step(np.int64(action)) for action in actions]
    for _ in range(2):
        found += [made.reset(), made.step(np.int64(1))]
    return [*found, made.action_space.sample()]


@each_way
@pytest.mark.parametrize("steps", range(len(tiny.ACTIONS)))
def test_a_copy_goes_on_as_the_environment_does(data: Path, way: Copy, steps: int) -> None:
    made = make(data, lang=("en", "hi"))
    made.action_space.seed(9)
    made.reset(seed=5)
    for action in tiny.ACTIONS[:steps]:
        made.step(np.int64(action))
    copied = way(made)
    assert copied.unwrapped is not made.unwrapped
    rest = [int(action) for action in tiny.ACTIONS[steps:]]
    there = played(copied, rest)
    assert there[len(rest) - 1][4]["scores"]["total"]["nDTW"] == 1.0
    assert same(there, played(made, rest))


@each_way
@pytest.mark.parametrize("expert", ["reference", "shortest"])
def test_the_expert_goes_on_too(data: Path, way: Copy, expert: str) -> None:
    """Also where the agent went its own way before, and while both are played by turns."""
    made = make(data, expert=expert, sensors=())
    _, info = made.reset(seed=1, options={"episode": "1"})
    copies = []
    wandering = [1, 0, 0, 2, 2, 0, 1, info["expert_action"]]
    for action in wandering:
        *_, info = made.step(np.int64(action))
        copies.append((way(made), info["expert_action"]))
    for number, (copied, advised) in enumerate(copies):
        apart = way(copied)
        for _ in range(40):
            *_, over, _, mine = copied.step(np.int64(advised))
            *_, other = apart.step(np.int64(advised))
            assert mine == other, number
            if over:
                break
            advised = mine["expert_action"]
        assert over
        assert mine["scores"]["turn 2"]["PTC"] == 1.0


@each_way
def test_before_the_first_episode_and_after_one(data: Path, way: Copy) -> None:
    made = make(data, steps_per_phase=1, render_mode="rgb_array")
    fresh = way(made)
    assert same(fresh.reset(seed=3), made.reset(seed=3))
    for _ in range(4):
        made.step(np.int64(1))
    over = way(made)
    assert same(over.render(), made.render())
    with pytest.raises(gymnasium.error.ResetNeeded):
        over.step(np.int64(1))
    assert same(over.reset(), made.reset())


@each_way
def test_wrappers_and_tokenizers_are_copied_with_it(data: Path, way: Copy) -> None:
    made = StartFrame(make(data, tokenizer=WordTokenizer(("go", "on"), 4)))
    made.reset(seed=1)
    made.step(np.int64(0))
    copied = way(made)
    assert copied.unwrapped.tokenizer.name == made.unwrapped.tokenizer.name  # type: ignore[attr-defined]
    assert same(copied.step(np.int64(0)), made.step(np.int64(0)))


@each_way
def test_drawn_tasks(way: Copy) -> None:
    made = gymnasium.make("arramon/ArraMonRoom-v0", image_size=16, sensors=("depth",))
    made.reset(seed=2)
    made.step(np.int64(1))
    copied = way(made)
    assert same([copied.step(np.int64(0)), copied.reset()], [made.step(np.int64(0)), made.reset()])


@each_way
@pytest.mark.parametrize("form", [raw_env, env])
def test_two_agents_by_turns(data: Path, way: Copy, form: Callable[..., Any]) -> None:
    made = form(data=data, split="tiny", image_size=16, message_length=2)
    made.reset(seed=1)
    for step, action in enumerate(tiny.ACTIONS):
        copied = way(made)
        for each in (made, copied):
            each.step({"action": int(action), "message": [step, 7]})
        agents = ("navigator", "assembler")
        assert same([copied.observe(agent) for agent in agents], [made.observe(agent) for agent in agents])
        assert (copied.rewards, copied.infos, copied.agent_selection) == (
            made.rewards, made.infos, made.agent_selection,
        )  # fmt: skip
    assert made.terminations["navigator"]
    assert made.infos["navigator"]["scores"]["total"]["PTC"] == 1.0


@each_way
def test_two_agents_in_parallel(data: Path, way: Copy) -> None:
    made = parallel_env(data=data, split="tiny", image_size=16)
    made.reset(seed=4)
    for action in tiny.ACTIONS:
        copied = way(made)
        actions = dict.fromkeys(made.agents, int(action))
        assert same(copied.step(actions), made.step(actions))
    copied = way(made)
    assert same(copied.reset(), made.reset())


def test_a_shallow_copy_shares_nothing_that_changes(data: Path) -> None:
    made = make(data, sensors=()).unwrapped
    made.action_space.seed(9)
    made.reset(seed=5)
    apart = pickle.loads(pickle.dumps(made))
    copied = copy.copy(made)
    played(copied, [0, 1])
    assert same(played(made, []), played(apart, []))


@pytest.mark.parametrize("form", [raw_env, parallel_env])
def test_a_shallow_copy_of_two_agents_shares_nothing_that_changes(data: Path, form: Callable[..., Any]) -> None:
    def seen(env: Any) -> list[Any]:
        found = []
        for _ in range(2):
            env.reset()
            found.append([env.infos if form is raw_env else None, env._episode.player.episode_id])
            action = int(env.action_space("navigator").sample())
            env.step(action if form is raw_env else dict.fromkeys(env.agents, action))
            found.append([action, env._episode.observation("navigator")["last_action"]])
        return found

    made = form(data=data, split="tiny", image_size=16, sensors=())
    made.action_space("navigator").seed(9)
    made.reset(seed=5)
    apart = pickle.loads(pickle.dumps(made))
    seen(copy.copy(made))
    assert seen(made) == seen(apart)


@pytest.mark.parametrize("way", [*COPIES.values(), copy.copy], ids=[*COPIES, "copy"])
@pytest.mark.parametrize("form", [make, raw_env, parallel_env])
@pytest.mark.parametrize("has_begun", [False, True])
def test_a_copy_of_a_closed_environment_is_closed(
    data: Path, way: Copy, form: Callable[..., Any], has_begun: bool
) -> None:
    made = form(data=data, split="tiny", image_size=16) if form is not make else make(data).unwrapped
    if has_begun:
        made.reset(seed=1)
    made.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        way(made).reset(seed=1)


def test_a_copy_holds_no_frames(data: Path) -> None:
    """Only the bounds of the spaces grow with the size of images."""
    made = make(data, image_size=224).unwrapped  # A wrapper of Gymnasium keeps the latest observation.
    made.reset(seed=1)
    made.step(np.int64(0))
    spaces = len(pickle.dumps((made.observation_space, made.action_space)))
    assert len(pickle.dumps(made)) < spaces + 5_000


def test_data_that_changed_is_noticed(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    made = make(tmp_path)
    made.reset(seed=1)
    pickled = pickle.dumps(made)
    tiny.write(tmp_path, count=9)
    with pytest.raises(CannotCopy, match=r"cannot be restored: the split 'tiny' in .* is \w{12} now, and was \w{12}"):
        pickle.loads(pickled)


def test_a_relative_data_folder_is_found_from_elsewhere(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(data)
    made = make(Path())
    made.reset(seed=1)
    monkeypatch.chdir(tmp_path)
    assert same(copy.deepcopy(made).step(np.int64(0)), made.step(np.int64(0)))


def test_a_vector_environment_says_that_it_cannot(data: Path) -> None:
    made: Any = gymnasium.make_vec("arramon/ArraMon-v0", 2, data=data, split="tiny", sensors=())
    for way in COPIES.values():
        with pytest.raises(CannotCopy, match="a vector environment cannot be pickled or copied"):
            way(made)
    made.close()

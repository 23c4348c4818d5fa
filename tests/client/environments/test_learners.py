"""Learners' libraries: their own checks, and learning past turn 2, which `Discrete(2, start=1)` did not survive."""

import warnings
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import arramon_client.environments  # noqa: F401 - registers the environments

SENSORS = ("rgb", "depth", "segmentation", "pose")

NUMBERS = ("instruction_tokens", "turn", "phase", "steps_left", "last_action")

UNCONVENTIONAL = "has an unconventional shape"
"""Advice of Stable-Baselines3 against images without channels; it learns from them all the same."""


@pytest.fixture(autouse=True)
def strict() -> Iterator[None]:
    """Warnings are errors, but for those with which the libraries import others."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name in ("stable_baselines3", "torchrl.envs", "examples.torchrl_ppo", "examples.sb3_vector"):
            import_module(name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def arguments(data: Path, **more: Any) -> dict[str, Any]:
    """Two steps a phase: turn 2 begins after four, and an episode has eight at most."""
    return {"data": data, "split": "tiny", "image_size": 40, "steps_per_phase": 2, **more}


def turns_of(values: Any) -> set[int]:
    """The turns among one-hot vectors of TorchRL, (..., 3)."""
    assert values.shape[-1] == 3
    assert (values.sum(-1) == 1).all()
    return set(values.argmax(-1).flatten().tolist())


def test_no_space_begins_elsewhere_than_at_0(data: Path) -> None:
    made = gymnasium.make("arramon/ArraMon-v0", **arguments(data, sensors=SENSORS))
    for name, space in made.observation_space.spaces.items():  # type: ignore[attr-defined]
        if isinstance(space, gymnasium.spaces.Discrete):
            assert space.start == 0, name
        if isinstance(space, gymnasium.spaces.Box):
            assert np.isfinite(space.low).all(), name
            assert np.isfinite(space.high).all(), name
    assert made.action_space.start == 0  # type: ignore[attr-defined]


def test_turns_flatten_to_one_hot_vectors(data: Path) -> None:
    made = gymnasium.make("arramon/ArraMon-v0", **arguments(data, observe=("turn",)))
    flat = gymnasium.wrappers.FlattenObservation(made)
    flat.reset(seed=1)
    assert [flat.step(np.int64(1))[0].tolist() for _ in range(8)] == [*[[0, 1, 0]] * 3, *[[0, 0, 1]] * 5]


@pytest.mark.parametrize("keys", [NUMBERS, ("rgb", "pose", *NUMBERS)])
def test_stable_baselines_check(data: Path, keys: tuple[str, ...]) -> None:
    from stable_baselines3.common.env_checker import check_env

    check_env(gymnasium.make("arramon/ArraMon-v0", **arguments(data, observe=keys)).unwrapped)


def test_stable_baselines_check_of_images_without_channels(data: Path) -> None:
    from stable_baselines3.common.env_checker import check_env

    made = gymnasium.make("arramon/ArraMon-v0", **arguments(data, observe=("depth", "segmentation", "turn")))
    with pytest.warns(UserWarning, match=UNCONVENTIONAL) as caught:
        check_env(made.unwrapped)
    assert all(UNCONVENTIONAL in str(each.message) for each in caught)


@pytest.mark.parametrize("keys", [NUMBERS, ("rgb", "turn"), ("depth", "segmentation", "pose", "turn")])
def test_stable_baselines_learns_past_turn_2(data: Path, keys: tuple[str, ...]) -> None:
    from stable_baselines3 import PPO

    made = gymnasium.make("arramon/ArraMon-v0", **arguments(data, observe=keys))
    model = PPO("MultiInputPolicy", made, n_steps=64, batch_size=32, n_epochs=1, seed=1, device="cpu")
    before = [each.clone() for each in model.policy.parameters()]
    model.learn(128)
    assert set(model.rollout_buffer.observations["turn"].ravel().tolist()) == {1, 2}
    assert any((one != other).any() for one, other in zip(before, model.policy.parameters(), strict=True))


@pytest.mark.parametrize("lang", ["hi", ("en", "hi")])
def test_torchrl_check(data: Path, lang: Any) -> None:
    from torchrl.envs import GymEnv
    from torchrl.envs.utils import check_env_specs

    check_env_specs(GymEnv("arramon/ArraMon-v0", **arguments(data, sensors=SENSORS, lang=lang)))
    check_env_specs(GymEnv("arramon/ArraMonRoom-v0", image_size=16, steps_per_phase=2, lang=lang))


def test_torchrl_plays_past_turn_2_with_texts(data: Path) -> None:
    from torchrl.envs import GymEnv

    made = GymEnv("arramon/ArraMon-v0", **arguments(data, lang="hi"))
    found: set[int] = set()
    for _ in range(3):
        rollout = made.rollout(20)
        found |= turns_of(rollout["turn"])
        assert next(iter(rollout["instruction"])) == "धारीदार लाल मग तक चलें।"
        assert bool(rollout["next", "terminated"][-1])
    assert found == {1, 2}


@pytest.mark.parametrize("processes", [1, 2])
def test_torchrl_plays_vectors(data: Path, processes: int) -> None:
    from torchrl.envs import GymWrapper
    from torchrl.envs.utils import check_env_specs

    keys = ("rgb", "segmentation", "instruction_tokens", "turn")
    inner = gymnasium.make_vec(
        "arramon/ArraMon-v0", 3, processes=processes, autoreset_mode="Disabled", **arguments(data, observe=keys)
    )
    assert inner.autoreset_mode == inner.metadata["autoreset_mode"]  # type: ignore[attr-defined]
    made = GymWrapper(inner)
    check_env_specs(made)
    rollout = made.rollout(24, break_when_any_done=False)
    assert rollout.batch_size == (3, 24)
    assert turns_of(rollout["turn"]) == {1, 2}
    made.close()


def test_torchrl_plays_vectors_with_texts(data: Path) -> None:
    from torchrl.envs.utils import check_env_specs

    from examples.torchrl_ppo import make_vector

    made = make_vector(**arguments(data, sensors=SENSORS))
    check_env_specs(made)
    rollout = made.rollout(10, break_when_any_done=False)
    assert turns_of(rollout["turn"]) == {1, 2}
    for texts, phases in zip(rollout["instruction"], rollout["phase"].argmax(-1).tolist(), strict=True):
        expected = {0: "Go on to the striped red mug.", 1: "Put it two steps ahead."}
        assert list(texts) == [expected[phase] for phase in phases]
    made.close()


def test_stable_baselines_on_a_vector(data: Path) -> None:
    """The adapter of the example gives what single environments give."""
    from stable_baselines3.common.vec_env import DummyVecEnv

    from examples.sb3_vector import VectorForSB3

    given = arguments(data, observe=("rgb", "turn", "instruction_tokens"), reward="progress")
    ours: Any = VectorForSB3(gymnasium.make_vec("arramon/ArraMon-v0", 3, autoreset_mode="SameStep", **given))
    theirs: Any = DummyVecEnv([lambda: gymnasium.make("arramon/ArraMon-v0", **given)] * 3)
    for each in (ours, theirs):
        each.seed(4)
    one, other = ours.reset(), theirs.reset()
    rng = np.random.default_rng(0)
    for _ in range(30):
        assert all(np.array_equal(one[key], other[key]) for key in other)
        actions = rng.integers(4, size=3)
        (one, mine, ended, infos), (other, rewards, dones, theirs_infos) = ours.step(actions), theirs.step(actions)
        assert np.array_equal(ended, dones)
        assert np.allclose(mine, rewards)
        for here, there in zip(infos, theirs_infos, strict=True):
            last, expected = here.get("terminal_observation"), there.get("terminal_observation")
            assert (last is None) == (expected is None)
            assert last is None or all(np.array_equal(last[key], expected[key]) for key in expected)
    assert ours.get_attr("render_mode") == [None] * 3
    ours.close()

"""Every vector wrapper of Gymnasium over the vector environment, in one process and in two; and what LeRobot asks."""

import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import vector as wrappers

from arramon_client.environments import BadArgument
from arramon_client.environments.vector import ArraMonVectorEnv, make_room_vector

COUNT = 3

NUMBERS = ("rgb", "turn", "phase", "steps_left", "last_action")
"""Keys that can be flattened."""


@pytest.fixture(params=[1, 2])
def processes(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture
def opened(data: Path) -> Iterator[Callable[..., Any]]:
    """Makes environments, and closes them in the end."""
    made: list[Any] = []

    def make(processes: int, **more: Any) -> Any:
        arguments = {"data": data, "split": "tiny", "image_size": 16, "steps_per_phase": 3, **more}
        made.append(gymnasium.make_vec("arramon/ArraMon-v0", COUNT, processes=processes, **arguments))
        return made[-1]

    yield make
    for env in made:
        env.close()


def rgb(env: Any) -> Any:
    """The environment with nothing but its colours, as wrappers of images need it."""
    only = gymnasium.spaces.Box(0, 255, (16, 16, 3), np.uint8)
    return wrappers.TransformObservation(
        env, lambda values: values["rgb"], gymnasium.vector.utils.batch_space(only, COUNT), only
    )


WRAPPED: dict[str, Callable[[Any], Any]] = {
    "RecordEpisodeStatistics": wrappers.RecordEpisodeStatistics,
    "DictInfoToList": wrappers.DictInfoToList,
    "FilterObservation": lambda env: wrappers.FilterObservation(env, NUMBERS),
    "FlattenObservation": lambda env: wrappers.FlattenObservation(wrappers.FilterObservation(env, NUMBERS)),
    "TransformObservation": rgb,
    "VectorizeTransformObservation": lambda env: wrappers.VectorizeTransformObservation(
        rgb(env), gymnasium.wrappers.TransformObservation, func=lambda pixels: pixels, observation_space=None
    ),
    "GrayscaleObservation": lambda env: wrappers.GrayscaleObservation(rgb(env)),
    "ReshapeObservation": lambda env: wrappers.ReshapeObservation(rgb(env), (16, 48)),
    "RescaleObservation": lambda env: wrappers.RescaleObservation(
        wrappers.DtypeObservation(rgb(env), np.float32), np.float32(0.0), np.float32(1.0)
    ),
    "DtypeObservation": lambda env: wrappers.DtypeObservation(rgb(env), np.float32),
    "ResizeObservation": lambda env: wrappers.ResizeObservation(rgb(env), (8, 8)),
    "NormalizeObservation": lambda env: wrappers.NormalizeObservation(rgb(env)),
    "NormalizeReward": wrappers.NormalizeReward,
    "TransformReward": lambda env: wrappers.TransformReward(env, lambda reward: reward + 1.0),
    "VectorizeTransformReward": lambda env: wrappers.VectorizeTransformReward(
        env, gymnasium.wrappers.TransformReward, func=lambda reward: reward
    ),
    "ClipReward": lambda env: wrappers.ClipReward(env, 0.0, 1.0),
    "TransformAction": lambda env: wrappers.TransformAction(env, lambda actions: actions, env.action_space),
    "VectorizeTransformAction": lambda env: wrappers.VectorizeTransformAction(
        env, gymnasium.wrappers.TransformAction, func=lambda action: action, action_space=None
    ),
}
"""Wrappers by their names. ClipAction and RescaleAction are for continuous actions."""

NEEDS = {"ResizeObservation": "cv2"}


def test_every_wrapper_is_tried() -> None:
    others = {"ClipAction", "RescaleAction", "RecordVideo", "HumanRendering", "NumpyToTorch", "JaxToNumpy"}
    others |= {"JaxToTorch", "ArrayConversion"}
    assert {name for name in wrappers.__all__ if name[0].isupper()} <= {*WRAPPED, *others}
    assert all(inspect.isclass(getattr(wrappers, name)) for name in WRAPPED)


@pytest.mark.parametrize("name", WRAPPED)
def test_a_wrapper_plays(opened: Any, processes: int, name: str) -> None:
    if name in NEEDS:
        pytest.importorskip(NEEDS[name], reason=f"{name} needs {NEEDS[name]}")
    env = WRAPPED[name](opened(processes, reward="progress"))
    env.reset(seed=0)
    over = 0
    for step in range(16):
        values, rewards, terminated, truncated, _ = env.step(np.full(COUNT, step % 3))
        if name not in ("DictInfoToList", "TransformAction"):
            assert env.observation_space.contains(values) or name in ("NormalizeObservation", "RescaleObservation")
        over += int(terminated.sum())
        assert rewards.shape == terminated.shape == truncated.shape == (COUNT,)
    assert over >= COUNT
    if name == "RecordEpisodeStatistics":
        assert set(env.length_queue) == {12}


def test_videos(opened: Any, processes: int, tmp_path: Path) -> None:
    pytest.importorskip("moviepy", reason="RecordVideo needs moviepy: pip install moviepy")
    env = wrappers.RecordVideo(
        opened(processes, render_mode="rgb_array"), str(tmp_path / "videos"), episode_trigger=lambda number: number == 0
    )
    env.reset(seed=0)
    for _ in range(14):
        env.step(np.ones(COUNT, int))
    env.close()
    assert [path.suffix for path in (tmp_path / "videos").iterdir()] == [".mp4"]


def test_tensors_with_texts(opened: Any, processes: int) -> None:
    torch = pytest.importorskip("torch", reason="NumpyToTorch needs torch")
    pytest.importorskip("array_api_compat", reason="NumpyToTorch needs array-api-compat: pip install array-api-compat")
    from gymnasium.wrappers.vector import NumpyToTorch

    env = NumpyToTorch(opened(processes, lang="hi"))
    values, infos = env.reset(seed=0)
    assert values["instruction"] == ("धारीदार लाल मग तक चलें।",) * COUNT
    assert infos["language"].tolist() == ["hi"] * COUNT
    for _ in range(13):
        values, rewards, terminated, _, infos = env.step(torch.ones(COUNT, dtype=torch.int64))
        assert values["rgb"].dtype is torch.uint8
        assert rewards.dtype is torch.float64
        if terminated.all():
            assert infos["cause"].tolist() == ["STEP_LIMIT"] * COUNT
    single = gymnasium.wrappers.NumpyToTorch(gymnasium.make("arramon/ArraMonRoom-v0", sensors=("rgb",), image_size=16))
    assert isinstance(single.reset(seed=0)[0]["instruction"], str)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
@pytest.mark.parametrize("limit", [1, 5, 12, 13])
def test_truncation_is_that_of_gymnasium(data: Path, opened: Any, processes: int, mode: str, limit: int) -> None:
    """An episode of 12 steps, whose end may come with the limit."""
    ours = opened(processes, autoreset_mode=mode, max_episode_steps=limit)
    arguments: dict[str, Any] = {"data": data, "split": "tiny", "image_size": 16, "steps_per_phase": 3}
    theirs = SyncVectorEnv(
        [lambda: gymnasium.make("arramon/ArraMon-v0", max_episode_steps=limit, **arguments) for _ in range(COUNT)],
        autoreset_mode=AutoresetMode(mode),
    )
    assert ours.get_attr("_max_episode_steps") == (limit,) * COUNT
    ours.reset(seed=2)
    theirs.reset(seed=2)
    for step in range(30):
        actions = np.array([step % 3, 1, 2])
        one, other = ours.step(actions), theirs.step(actions)
        assert data_equivalence(one[:4], other[:4], exact=True)
        assert one[4].keys() == other[4].keys()
        over = one[2] | one[3]
        if mode == "Disabled" and over.any():
            with pytest.raises(gymnasium.error.ResetNeeded, match="have ended"):
                ours.step(actions)
            ours.reset(seed=2, options={"reset_mask": over})
            theirs.reset(seed=2, options={"reset_mask": over})
    theirs.close()


@pytest.mark.parametrize("limit", [0, -1, 1.5, True, "5"])
def test_wrong_limits(limit: Any) -> None:
    with pytest.raises(BadArgument, match=r"max_episode_steps is .*, expected None or a number from 1"):
        ArraMonVectorEnv(2, max_episode_steps=limit)


def test_attributes(opened: Any, processes: int) -> None:
    """As LeRobot reads them: by `call`, before the first episode, too."""
    env = opened(processes, lang="hi")
    assert env.call("task") == env.call("task_description") == ("",) * COUNT
    env.reset(options={"episode": ["1", "2", "4"]})
    assert env.call("task_description") == ("धारीदार लाल मग तक चलें।",) * COUNT
    for _ in range(3):
        env.step(np.array([1, 1, 0]))
    assert env.get_attr("task") == ("assembly",) * COUNT
    assert env.get_attr("episode_id") == ("1", "2", "4")
    assert env.call("_max_episode_steps") == (12,) * COUNT
    assert env.call("render") == (None,) * COUNT
    env.set_attr("colour", ["red", "green", "blue"])
    env.set_attr("size", 5)
    assert env.get_attr("colour") == ("red", "green", "blue")
    assert env.get_attr("size") == (5, 5, 5)
    with pytest.raises(AttributeError, match="nonsense"):
        env.get_attr("nonsense")
    with pytest.raises(AttributeError, match="task"):
        env.set_attr("task", "another")
    with pytest.raises(BadArgument, match="there are 2 values, expected 3"):
        env.set_attr("size", [1, 2])
    if processes > 1:
        with pytest.raises(BadArgument, match="'player' cannot be passed between processes"):
            env.get_attr("player")
        with pytest.raises(BadArgument, match="cannot be sent to a process"):
            env.set_attr("size", lambda: 1)
    assert env.get_attr("size") == (5, 5, 5)  # It goes on.
    env.step(np.zeros(COUNT, int))


def test_most_steps_of_an_episode(opened: Any) -> None:
    for more, steps in (({}, 12), ({"turn": 2}, 6), ({"phases": ("assembly",)}, 6), ({"start": "assembly"}, 9)):
        assert opened(1, **more).call("_max_episode_steps") == (steps,) * COUNT


def test_a_single_environment_has_the_same_attributes(data: Path) -> None:
    env: Any = gymnasium.make("arramon/ArraMon-v0", data=data, split="tiny", image_size=16)
    assert (env.get_wrapper_attr("task"), env.get_wrapper_attr("task_description")) == ("", "")
    env.reset(seed=0)
    assert env.get_wrapper_attr("task") == "navigation"
    assert env.get_wrapper_attr("task_description") == "Go on to the striped red mug."


def test_after_close(opened: Any, data: Path, processes: int) -> None:
    env = opened(processes, render_mode="rgb_array")
    env.reset(seed=0)
    env.close()
    env.close()
    calls = {"step": (np.zeros(COUNT, int),), "reset": (), "render": (), "call": ("task",), "heads": ("",)}
    for method, arguments in {**calls, "set_attr": ("x", 1)}.items():
        with pytest.raises(gymnasium.error.ClosedEnvironmentError, match=rf"{method}\(\) was called after close\(\)"):
            getattr(env, method)(*arguments)
    single: Any = gymnasium.make("arramon/ArraMon-v0", data=data, split="tiny", image_size=16)
    single.reset(seed=0)
    single.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError, match=r"step\(\) was called after close"):
        single.step(0)
    with pytest.raises(gymnasium.error.ClosedEnvironmentError, match=r"reset\(\) was called after close"):
        single.reset(seed=0)


def test_arguments_are_listed() -> None:
    for make in (ArraMonVectorEnv, make_room_vector):
        with pytest.raises(TypeError, match="processes, autoreset_mode, context, render_mode, batch_size") as caught:
            make(2, frameskip=4)
        assert "max_episode_steps" in str(caught.value)

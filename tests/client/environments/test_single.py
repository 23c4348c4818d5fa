"""The Gymnasium environment in this process."""

import itertools
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import arramon_client.environments as environments
from tests import tiny

FIRST = "Go on to the striped red mug."


def make(data: Path, id_: str = "arramon/ArraMon-v0", **options: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(id_, **{"data": data, "split": "tiny", "image_size": 64, **options})


@pytest.mark.parametrize("language", ["en", "hi"])
@pytest.mark.parametrize("id_", ["arramon/ArraMon-v0", "ArraMon-v0"])
def test_gymnasiums_own_check_has_nothing_to_say(data: Path, language: str, id_: str) -> None:
    env = make(data, id_, lang=language, sensors=("rgb", "depth", "segmentation", "pose"), render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
    env.close()


@pytest.mark.parametrize("language", ["en", "hi"])
def test_the_room_alone_passes_it_too(language: str) -> None:
    env = gymnasium.make("arramon/ArraMonRoom-v0", lang=language, image_size=64)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
    env.close()


def test_an_observation(data: Path) -> None:
    env = make(data, sensors=("depth", "rgb"))
    values, info = env.reset(options={"episode": "1"})
    assert env.observation_space.spaces.keys() == values.keys()  # type: ignore[attr-defined]
    assert values["rgb"].shape == (64, 64, 3)
    assert (values["depth"].shape, values["depth"].dtype) == ((64, 64), np.float32)
    assert values["depth"].max() <= 65.535
    assert values["instruction"] == FIRST
    assert (values["turn"], values["phase"], values["steps_left"][0], values["last_action"]) == (1, 0, 150, 4)
    assert bytes(int(each) - 3 for each in values["instruction_tokens"] if each >= 3).decode() == FIRST
    assert info == {"episode_id": "1", "split": "tiny", "language": "en", "tokenizer": "utf8-bytes"}
    values, reward, terminated, truncated, info = env.step(2)
    assert (values["steps_left"][0], values["last_action"]) == (149, 2)
    assert (reward, terminated, truncated, info) == (0.0, False, False, {})


def test_the_text_space_is_the_splits_own(data: Path) -> None:
    env = make(data, lang="hi")
    space = env.observation_space["instruction"]  # type: ignore[index]
    assert space.contains("धारीदार लाल मग तक चलें।")
    assert not space.contains("Turn left.")
    assert space.max_length == len("धारीदार लाल मग तक चलें।")


def test_the_ground_truth_scores_one_in_all(data: Path) -> None:
    env = make(data, reward="sparse")
    env.reset(options={"episode": "1"})
    steps = [env.step(action) for action in tiny.ACTIONS]
    assert [step[1] for step in steps] == [0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 1]
    assert [step[2] for step in steps] == [False] * 12 + [True]
    over = [step[4]["phase_ended"] for step in steps if "phase_ended" in step[4]]
    assert over == ["turn 1, navigation", "turn 1, assembly", "turn 2, navigation", "turn 2, assembly"]
    last = steps[-1][4]
    assert last["cause"] == "AGENT_FINISHED"
    assert set(last["scores"]["total"].values()) == {1.0}
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"call reset\(\)"):
        env.step(0)


def test_progress_along_the_ground_truth_adds_up_to_one_a_phase(data: Path) -> None:
    env = make(data, reward="progress")
    env.reset(options={"episode": "1"})
    rewards = [float(env.step(action)[1]) for action in tiny.ACTIONS]
    # Two units to go, one cell to go; then, after a turn, the same once more. The ends of phases add the metrics.
    assert rewards == pytest.approx([0.5, 0.5, 1.0, 1.0, 1.0, 0, 0, 0, 0.5, 0.5, 1.0, 1.0, 1.0])


def test_the_step_limit_of_a_phase_is_a_transition(data: Path) -> None:
    env = make(data, steps_per_phase=2)
    env.reset(options={"episode": "1"})
    steps = [env.step(1) for _ in range(8)]
    assert [(s[0]["turn"], s[0]["phase"]) for s in steps] == [
        (1, 0), (1, 1), (1, 1), (2, 0), (2, 0), (2, 1), (2, 1), (2, 1),
    ]  # fmt: skip
    assert [s[2] for s in steps] == [False] * 7 + [True]
    assert not any(s[3] for s in steps)
    assert steps[-1][4]["cause"] == "STEP_LIMIT"


def test_a_seed_draws_the_episodes(data: Path) -> None:
    def ids(seed: int) -> list[str]:
        env = make(data, sensors=())
        first = env.reset(seed=seed)[1]["episode_id"]
        return [first, *(env.reset()[1]["episode_id"] for _ in range(5))]

    assert ids(3) == ids(3)
    assert len({tuple(ids(seed)) for seed in range(5)}) > 1
    assert set(itertools.chain(*(ids(seed) for seed in range(10)))) == {"0", "1", "2", "3", "4", "5"}
    hindi = make(data, sensors=(), lang="hi")
    assert {hindi.reset()[1]["episode_id"] for _ in range(40)} == {"1", "2", "4", "5"}


@pytest.mark.parametrize("size", [8, 64, 84, 448])
def test_sizes_of_images(data: Path, size: int) -> None:
    values, _ = make(data, image_size=size).reset(options={"episode": "1"})
    assert values["rgb"].shape == (size, size, 3)
    assert values["rgb"].std() > 0


def test_a_hidden_split_tells_neither_rewards_nor_scores(data: Path) -> None:
    env = make(data, split="secret", steps_per_phase=1)
    env.reset(options={"episode": "0"})
    steps = [env.step(0) for _ in range(4)]
    assert [step[1] for step in steps] == [0.0] * 4
    assert steps[-1][4] == {"phase_ended": "turn 2, assembly", "cause": "STEP_LIMIT"}
    assert env.unwrapped.player.split.sensors == ("rgb", "depth")  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("turn", "start", "expected", "left"),
    [(1, "assembly", (1, 1), 10), (2, "navigation", (2, 0), 8), (2, "assembly", (2, 1), 2)],
)
def test_it_begins_in_a_phase_as_if_all_before_had_been_right(
    data: Path, turn: int, start: str, expected: tuple[int, int], left: int
) -> None:
    env = make(data, turn=turn, start=start)
    values, _ = env.reset(options={"episode": "1"})
    assert (values["turn"], values["phase"]) == expected
    assert values["steps_left"][0] == 150
    steps = [env.step(action) for action in tiny.ACTIONS[-left:]]
    assert steps[-1][2]
    assert set(steps[-1][4]["scores"]["total"].values()) == {1.0}


def test_the_ground_truth_plays_the_phases_that_the_agent_does_not(data: Path) -> None:
    env = make(data, phases=("assembly",), reward="sparse")
    values, _ = env.reset(options={"episode": "1"})
    seen = [(int(values["turn"]), int(values["phase"]))]
    rewards = []
    for action in (0, 3, 0, 3):
        values, reward, terminated, _, info = env.step(action)
        seen.append((int(values["turn"]), int(values["phase"])))
        rewards.append(reward)
    assert seen == [(1, 1), (1, 1), (2, 1), (2, 1), (2, 1)]
    assert rewards == [0, 1, 0, 1]
    assert terminated
    assert info["scores"]["total"]["nDTW"] == 1.0


def test_pictures(data: Path) -> None:
    env = make(data, render_mode="rgb_array", lang="hi")
    env.reset(options={"episode": "1"})
    street: Any = env.render()
    assert (street.shape, street.dtype) == ((456, 672, 3), np.uint8)
    for action in tiny.ACTIONS[:3]:
        env.step(action)
    room: Any = env.render()
    assert (street[:336, :336] != room[:336, :336]).any()  # the view
    assert (street[:336, 336:] != room[:336, 336:]).any()  # the map
    assert room[336:].min() < 100  # words
    window = make(data, render_mode="human")
    window.reset()
    assert window.render() is None
    window.close()


def test_words_as_numbers(data: Path) -> None:
    env = make(data, tokenizer="words", lang="hi", sensors=())
    values, info = env.reset(options={"episode": "1"})
    tokenizer = env.unwrapped.tokenizer  # type: ignore[attr-defined]
    assert info["tokenizer"] == tokenizer.name
    known = tokenizer.vocabulary
    words = [known[each - 3] for each in values["instruction_tokens"] if each >= 3]
    assert words == ["धारीदार", "लाल", "मग", "तक", "चलें", "।"]


def test_public_names() -> None:
    assert environments.__all__ == [
        "REWARDS", "ArraMonEnv", "BadArgument", "ByteTokenizer", "FactoredLabels", "NoBackend", "Tokenizer",
        "WordTokenizer", "factored", "register",
    ]  # fmt: skip
    assert all(hasattr(environments, name) for name in environments.__all__)

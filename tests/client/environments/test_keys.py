"""Which keys an observation has, and in which languages it is."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from arramon_client.environments import BadArgument
from arramon_client.environments.spaces import KEYS
from arramon_client.environments.two_agents import env, parallel_env, raw_env

CHOSEN = ("instruction_tokens", "rgb", "turn")


def arguments(data: Path, **more: Any) -> dict[str, Any]:
    return {"data": data, "split": "tiny", "image_size": 16, **more}


def make(data: Path, **more: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make("arramon/ArraMon-v0", **arguments(data, **more))


def keys(made: gymnasium.Env[Any, Any]) -> set[str]:
    return set(made.observation_space.spaces)  # type: ignore[attr-defined]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("chosen", [CHOSEN, ("pose",), ("instruction",), ("last_action", "steps_left"), KEYS])
def test_one_agent(data: Path, chosen: tuple[str, ...]) -> None:
    made = make(data, observe=chosen)
    assert keys(made) == set(chosen)
    observation, _ = made.reset(seed=1)
    assert observation.keys() == set(chosen)
    assert made.step(np.int64(1))[0].keys() == set(chosen)
    check_env(made.unwrapped, skip_render_check=True)


def test_the_values_are_those_of_a_whole_observation(data: Path) -> None:
    whole, part = make(data), make(data, observe=CHOSEN)
    for one, other in ((whole.reset(seed=3), part.reset(seed=3)), (whole.step(np.int64(2)), part.step(np.int64(2)))):
        assert all(np.array_equal(one[0][key], other[0][key]) for key in CHOSEN)
        assert one[1:] == other[1:]


def test_what_is_not_observed_is_not_drawn(data: Path) -> None:
    made = make(data, observe=("turn",), sensors=("rgb", "segmentation"))
    made.reset(seed=1)
    assert made.unwrapped.player.latest().rgb is None  # type: ignore[attr-defined]
    assert made.unwrapped.labels == ()  # type: ignore[attr-defined]


def test_pictures_do_not_need_the_keys(data: Path) -> None:
    made = make(data, observe=("turn",), render_mode="rgb_array")
    made.reset(seed=1)
    picture: Any = made.render()
    assert picture.shape == (456, 672, 3)


@pytest.mark.parametrize("processes", [1, 2])
@pytest.mark.parametrize("chosen", [CHOSEN, ("instruction",), ("pose", "depth")])
def test_vectors(data: Path, chosen: tuple[str, ...], processes: int) -> None:
    made: Any = gymnasium.make_vec(
        "arramon/ArraMon-v0", 3, processes=processes, autoreset_mode="SameStep",
        **arguments(data, observe=chosen, steps_per_phase=1, render_mode="rgb_array"),
    )  # fmt: skip
    assert set(made.single_observation_space.spaces) == set(chosen)
    observation, _ = made.reset(seed=1)
    assert set(observation) == set(chosen)
    assert len(made.render()) >= 1
    for _ in range(4):
        observation, _, terminated, _, infos = made.step(np.ones(3, np.int64))
        assert set(observation) == set(chosen)
        assert made.observation_space.contains(observation)
    assert terminated.all()
    assert set(infos["final_obs"][0]) == set(chosen)
    made.close()


@pytest.mark.parametrize(
    "chosen", [CHOSEN, ("rgb", "active"), ("message", "instruction"), ("active", "message", "pose"), (*KEYS, "active")]
)
def test_two_agents(data: Path, chosen: tuple[str, ...]) -> None:
    for form in (raw_env, env):
        made: Any = form(**arguments(data, observe=chosen, message_length=2))
        made.reset(seed=1)
        for agent in made.possible_agents:
            assert set(made.observation_space(agent).spaces) == set(chosen)
            assert made.observation_space(agent).contains(made.observe(agent))
    parallel = parallel_env(**arguments(data, observe=chosen, message_length=2))
    observations, _ = parallel.reset(seed=1)
    assert {agent: set(each) for agent, each in observations.items()} == {agent: set(chosen) for agent in observations}


WRONG: list[tuple[dict[str, Any], str]] = [
    (
        {"observe": ("rbg",)},
        "there is no key 'rbg' to observe; there are rgb, depth, .*, turn, phase, steps_left, last_",
    ),
    ({"observe": ("active",)}, "there is no key 'active' to observe"),
    ({"observe": ()}, "expected at least one of rgb, depth, segmentation, pose, instruction, instruction_tokens, turn"),
    ({"observe": "rgb"}, r"observe is 'rgb', expected a tuple of names, e\.g\. \(\"rgb\", \"instruction_tokens\"\)"),
    ({"observe": 5}, "observe is 5, expected a tuple of names"),
    ({"observe": ("pose",), "sensors": ("rgb",)}, r"observe names 'pose', but sensors is \('rgb',\): name it there"),
    ({"observe": ("pose",), "split": "secret"}, "the split 'secret' does not offer the sensor 'pose'"),
]


@pytest.mark.parametrize(("given", "message"), WRONG, ids=[str(given) for given, _ in WRONG])
def test_wrong_keys(data: Path, given: dict[str, Any], message: str) -> None:
    with pytest.raises(BadArgument, match=message):
        make(data, **given)
    with pytest.raises(BadArgument, match=message):
        gymnasium.make_vec("arramon/ArraMon-v0", 2, **arguments(data, **given))


def test_wrong_keys_of_two_agents(data: Path) -> None:
    with pytest.raises(BadArgument, match=r"there is no key 'message' to observe; there are .*, last_action, active$"):
        raw_env(**arguments(data, observe=("rgb", "message")))
    with pytest.raises(BadArgument, match="expected at least one of rgb"):
        raw_env(**arguments(data, observe=("active",)))


def test_several_languages(data: Path) -> None:
    made = make(data, lang=("en", "hi"), sensors=())
    assert made.observation_space == make(data, lang=["en", "hi"], sensors=()).observation_space
    found = set()
    for seed in range(60):
        observation, info = made.reset(seed=seed)
        assert made.observation_space.contains(observation)
        assert ("धारीदार" in observation["instruction"]) == (info["language"] == "hi")
        found.add((info["language"], info["episode_id"]))
    assert found == {*(("en", str(id_)) for id_ in range(6)), *(("hi", str(id_)) for id_ in (1, 2, 4, 5))}
    assert {made.reset(options={"lang": "hi"})[1]["language"] for _ in range(9)} == {"hi"}
    assert {made.reset(options={"episode": "3"})[1]["language"] for _ in range(9)} == {"en"}  # There is no Hindi.
    assert {made.reset(options={"episode": "1"})[1]["language"] for _ in range(20)} == {"en", "hi"}
    with pytest.raises(BadArgument, match="has no instructions in 'hi'"):
        made.reset(options={"episode": "3", "lang": "hi"})
    with pytest.raises(BadArgument, match=r"options\['lang'\] is 'fr', expected 'en', 'hi'"):
        made.reset(options={"lang": "fr"})


def test_words_of_several_languages(data: Path) -> None:
    made = make(data, lang=("en", "hi"), sensors=(), tokenizer="words")
    assert {"striped", "धारीदार"} <= set(made.unwrapped.tokenizer.vocabulary)  # type: ignore[attr-defined]


def test_vectors_and_rooms_of_several_languages(data: Path) -> None:
    made: Any = gymnasium.make_vec("arramon/ArraMon-v0", 8, **arguments(data, lang=("en", "hi"), sensors=()))
    observation, infos = made.reset(seed=0)
    assert set(infos["language"]) == {"en", "hi"}
    assert made.observation_space.contains(observation)
    room = gymnasium.make("arramon/ArraMonRoom-v0", lang=("en", "hi"), sensors=())
    said = {room.reset(seed=seed)[1]["language"] for seed in range(12)}
    assert said == {"en", "hi"}


def test_one_language_draws_the_same_episodes_as_ever(data: Path) -> None:
    made = make(data, sensors=())
    rng, _ = gymnasium.utils.seeding.np_random(11)
    expected = [str(int(rng.integers(6))) for _ in range(8)]
    ids = sorted(made.unwrapped.player.split.episode_ids)  # type: ignore[attr-defined]
    order = made.unwrapped.player.split.episode_ids  # type: ignore[attr-defined]
    assert ids == [str(number) for number in range(6)]
    first = made.reset(seed=11)[1]["episode_id"]
    assert [first, *(made.reset()[1]["episode_id"] for _ in range(7))] == [order[int(each)] for each in expected]

"""Arguments in the types that programs have at hand, what an environment says of them, and unknown ones."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from arramon_client.environments import ArraMonEnv, BadArgument, ByteTokenizer
from arramon_client.environments.errors import UnknownArgument
from arramon_client.environments.two_agents import parallel_env, raw_env
from arramon_client.transport.access import Access

INTEGERS = (np.int64, np.int32, np.uint8)


def arguments(data: Path, **more: Any) -> dict[str, Any]:
    return {"data": data, "split": "tiny", "image_size": 16, **more}


@pytest.mark.parametrize("kind", INTEGERS)
def test_integers_of_numpy(data: Path, kind: Callable[[int], Any]) -> None:
    given = arguments(data, image_size=kind(16), steps_per_phase=kind(3), turn=kind(2), sensors=np.array(["rgb"]))
    made = gymnasium.make("arramon/ArraMon-v0", **given)
    observation, _ = made.reset(seed=kind(3), options={"episode": kind(1)})
    assert (observation["turn"], observation["steps_left"][0]) == (2, 3)
    observation, *_ = made.step(kind(1))
    assert observation["last_action"] == 1
    assert made.step(np.array(2, np.int16))[0]["last_action"] == 2
    plain = gymnasium.make("arramon/ArraMon-v0", **arguments(data))
    assert made.reset(seed=kind(3))[1]["episode_id"] == plain.reset(seed=3)[1]["episode_id"]


@pytest.mark.parametrize("kind", INTEGERS)
def test_integers_of_numpy_in_vectors(data: Path, kind: Callable[[int], Any]) -> None:
    made: Any = gymnasium.make_vec("arramon/ArraMon-v0", kind(2), processes=kind(2), **arguments(data))
    alone: Any = gymnasium.make_vec("arramon/ArraMon-v0", 2, **arguments(data))
    for seed in (kind(5), np.array([5, 6], np.uint16), [kind(5), None]):
        found = made.reset(seed=seed)[1]["episode_id"]
        assert found[0] == alone.reset(seed=5)[1]["episode_id"][0]
    assert made.reset(options={"episode": kind(4)})[1]["episode_id"].tolist() == ["4", "4"]
    assert made.reset(options={"episode": np.array([1, 2])})[1]["episode_id"].tolist() == ["1", "2"]
    assert json.loads(made.spec.to_json())["kwargs"]["processes"] == 2
    made.close()


@pytest.mark.parametrize("kind", INTEGERS)
def test_integers_of_numpy_for_two_agents(data: Path, kind: Callable[[int], Any]) -> None:
    made = raw_env(message_length=kind(2), **arguments(data))
    made.reset(seed=kind(3))
    made.step({"action": kind(1), "message": np.array([kind(3), kind(4)])})
    parallel = parallel_env(**arguments(data))
    parallel.reset(seed=kind(3))
    parallel.step({"navigator": kind(1), "assembler": kind(0)})


@pytest.mark.parametrize("seed", [-1, 1.5, "3", True, np.float64(2)])
def test_wrong_seeds(data: Path, seed: Any) -> None:
    for made in (gymnasium.make("arramon/ArraMon-v0", **arguments(data)), raw_env(**arguments(data))):
        with pytest.raises(BadArgument, match=r"seed is .*, expected None or a whole number from 0"):
            made.reset(seed=seed)


@pytest.mark.parametrize("action", [np.array(1.0), np.float32(1), np.array([1, 2]), np.array(4), np.bool_(True)])
def test_arrays_that_are_no_action(data: Path, action: Any) -> None:
    made = ArraMonEnv(**arguments(data))
    made.reset(seed=1)
    with pytest.raises(gymnasium.error.InvalidAction, match=r"expected 0 \(forward\)"):
        made.step(action)


WRONG_TYPES: list[tuple[dict[str, Any], str]] = [
    ({"lang": 5}, "lang is 5, expected a tuple of names"),
    ({"lang": ()}, r"lang is \(\), expected a language, or several"),
    ({"lang": ("en", "fr")}, "the split 'tiny' has no language 'fr'; it has en, hi"),
    ({"split": None}, "split is None, expected the name of a split"),
    ({"split": 3}, "split is 3, expected the name of a split"),
    ({"data": 3}, "data is 3, expected a path"),
    ({"data": b"/tmp"}, "data is b'/tmp', expected a path"),
    ({"data": None, "server": 5}, "server is 5, expected an address, HOST:PORT"),
    ({"reward": np.array(["none", "sparse"])}, "reward is array.*, expected 'sparse', 'progress', 'none', None"),
    ({"sensors": (1, 2)}, r"sensors is \(1, 2\), expected a tuple of names"),
    ({"image_size": np.float64(64)}, "image_size is .*64.*, expected a number of pixels"),
    ({"data": None, "server": "localhost:1", "lang": ("en", "hi")}, "a run on a host has one language: name one"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "message"), WRONG_TYPES, ids=[str(given) for given, _ in WRONG_TYPES])
def test_wrong_types(data: Path, given: dict[str, Any], message: str) -> None:
    with pytest.raises(BadArgument, match=message):
        gymnasium.make("arramon/ArraMon-v0", **(arguments(data) | given))


def test_a_spec_is_json_and_makes_the_environment_again(data: Path) -> None:
    given = arguments(data, image_size=np.int64(16), sensors=("rgb",), lang=("en", "hi"), turn=np.int8(2))
    made = gymnasium.make("arramon/ArraMon-v0", **given)
    assert made.spec is not None
    text = made.spec.to_json()
    assert json.loads(text)["kwargs"] == {
        "data": str(data), "split": "tiny", "image_size": 16, "sensors": ["rgb"], "lang": ["en", "hi"], "turn": 2,
    }  # fmt: skip
    again = gymnasium.make(gymnasium.envs.registration.EnvSpec.from_json(text))
    assert again.observation_space == made.observation_space
    assert again.reset(seed=1)[1] == made.reset(seed=1)[1]


def test_the_spec_of_a_vector(data: Path) -> None:
    made = gymnasium.make_vec("arramon/ArraMon-v0", 2, autoreset_mode=gymnasium.vector.AutoresetMode.DISABLED,
                              **arguments(data))  # fmt: skip
    assert made.spec is not None
    assert json.loads(made.spec.to_json())["kwargs"]["autoreset_mode"] == "Disabled"
    made.close()


def test_a_token_is_not_in_the_spec(data: Path) -> None:
    made = gymnasium.make("arramon/ArraMon-v0", **arguments(data, access=Access(token="arr_secret")))
    assert made.spec is not None
    assert "secret" not in made.spec.to_json()
    assert "secret" not in repr(made.spec)


def test_a_tokenizer_of_ones_own_is_no_json(data: Path) -> None:
    made = gymnasium.make("arramon/ArraMon-v0", **arguments(data, tokenizer=ByteTokenizer(9)))
    assert made.spec is not None
    with pytest.raises((TypeError, ValueError), match=r"JSON|json"):
        made.spec.to_json()


LISTED = (
    "lang, split, sensors, image_size, server, data, reward, tokenizer, expert, phases, turn, start, steps_per_phase, "
    "access, observe"
)


@pytest.mark.parametrize(
    ("make", "more"),
    [
        (lambda **given: gymnasium.make("arramon/ArraMon-v0", **given), ", render_mode"),
        (raw_env, ", render_mode, message_length"),
        (parallel_env, ", render_mode, message_length"),
    ],
)
def test_an_unknown_argument_is_also_a_type_error(data: Path, make: Callable[..., Any], more: str) -> None:
    with pytest.raises(UnknownArgument) as caught:
        make(**arguments(data, frameskip=4))
    assert isinstance(caught.value, TypeError)
    assert isinstance(caught.value, BadArgument)
    said = str(caught.value)
    assert "unexpected keyword argument 'frameskip'" in said  # TorchRL looks for these words.
    assert f"there is no argument 'frameskip'; there are {LISTED}{more}" in said


def test_an_unknown_argument_of_a_vector(data: Path) -> None:
    with pytest.raises(UnknownArgument) as caught:
        gymnasium.make_vec("arramon/ArraMon-v0", 2, **arguments(data, frameskip=4))
    assert LISTED in str(caught.value)
    for name in ("num_envs", "processes", "autoreset_mode", "context", "render_mode"):
        assert f", {name}" in str(caught.value)


def test_a_room_lists_its_own() -> None:
    for make in (gymnasium.make, gymnasium.make_vec):
        with pytest.raises(UnknownArgument) as caught:
            make("arramon/ArraMonRoom-v0", image_sise=16)
        said = str(caught.value)
        assert "there are lang, sensors, image_size, data, reward, tokenizer, expert, turn, steps_per_phase" in said
        assert "did you mean 'image_size'?" in said

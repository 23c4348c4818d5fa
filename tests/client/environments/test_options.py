"""Bad input: Gymnasium's own errors, with messages that say what would be right."""

from functools import partial
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import gymnasium
import pytest

from arramon_client.environments import ArraMonEnv, BadArgument, NoBackend, players
from arramon_client.environments.two_agents import raw_env

WRONG: list[tuple[dict[str, Any], str]] = [
    ({"lang": "fr"}, "the split 'tiny' has no language 'fr'; it has en, hi"),
    ({"split": "none"}, "there is no split 'none' in .*; there are secret, tiny"),
    ({"sensors": ("smell",)}, "there is no sensor 'smell'; there are rgb, depth, segmentation, pose"),
    ({"sensors": ("oracle",)}, "there is no sensor 'oracle'"),
    ({"sensors": "rgb"}, "sensors is 'rgb', expected a tuple of names"),
    ({"split": "secret", "sensors": ("pose",)}, "'secret' does not offer the sensor 'pose'; it offers rgb, depth"),
    ({"image_size": 100}, "image_size is 100, expected a multiple of 8 from 8 to 448, or 84"),
    ({"image_size": 456}, "image_size is 456, expected a multiple of 8"),
    ({"image_size": "64"}, "image_size is '64', expected a number of pixels"),
    ({"reward": "money"}, "reward is 'money', expected 'sparse', 'progress', 'none', None"),
    ({"split": "secret", "reward": "sparse"}, "the split 'secret' is hidden: it has no rewards; use reward='none'"),
    ({"split": "secret", "expert": "reference"}, "the split 'secret' is hidden: it has no expert"),
    ({"expert": "wise"}, "expert is 'wise', expected 'reference', 'shortest', None"),
    ({"turn": 3}, "turn is 3, expected 1, 2"),
    ({"start": "lunch"}, "start is 'lunch', expected 'navigation', 'assembly'"),
    ({"phases": ()}, "phases is empty"),
    ({"phases": ("lunch",)}, "phases is 'lunch'"),
    ({"phases": ("navigation",), "turn": 2, "start": "assembly"}, "expected 'assembly' among them"),
    ({"steps_per_phase": 0}, "steps_per_phase is 0, expected a number from 1"),
    ({"steps_per_phase": True}, "steps_per_phase is True, expected a number from 1"),
    ({"steps_per_phase": 2.0}, r"steps_per_phase is 2\.0, expected a number from 1"),
    ({"turn": True}, "turn is True, expected 1, 2"),
    ({"image_size": True}, "image_size is True, expected a number of pixels"),
    ({"tokenizer": "bert"}, "tokenizer is 'bert', expected 'bytes', 'words'"),
    ({"tokenizer": 5}, "tokenizer is 5, expected 'bytes', 'words', or an object with name, size, length, encode"),
    ({"access": "token"}, "access is 'token', expected an Access"),
    ({"render_mode": "ascii"}, "render_mode is 'ascii'"),
    ({"language": "en"}, "there is no argument 'language'; there are lang, split"),
    ({"server": "localhost:1", "data": None, "reward": "sparse"}, "reward is 'sparse', which a host does not support"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "message"), WRONG, ids=[str(given) for given, _ in WRONG])
def test_wrong_arguments(data: Path, given: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"data": data, "split": "tiny", **given}
    # Gymnasium warns of an unknown mode of rendering before.
    make = ArraMonEnv if "render_mode" in given else partial(gymnasium.make, "arramon/ArraMon-v0")
    with pytest.raises(BadArgument, match=message) as caught:
        make(**arguments)
    assert isinstance(caught.value, gymnasium.error.Error)
    assert isinstance(caught.value, ValueError)


def test_a_folder_without_episodes(tmp_path: Path) -> None:
    with pytest.raises(BadArgument, match=r"there are no episodes in .*; make some with `arramon-server generate"):
        gymnasium.make("arramon/ArraMon-v0", data=tmp_path)


def test_an_unknown_episode(data: Path) -> None:
    env = gymnasium.make("arramon/ArraMon-v0", data=data, split="tiny", lang="hi", sensors=())
    with pytest.raises(BadArgument, match="there is no episode '99' in the split 'tiny'"):
        env.reset(options={"episode": "99"})
    with pytest.raises(BadArgument, match="the episode '0' has no instructions in 'hi'"):
        env.reset(options={"episode": "0"})


@pytest.mark.parametrize("action", [4, -1, 1.5, None, True, "0"])
def test_wrong_actions(data: Path, action: Any) -> None:
    env = gymnasium.make("arramon/ArraMon-v0", data=data, split="tiny", sensors=(), disable_env_checker=True)
    env.reset()
    with pytest.raises(gymnasium.error.InvalidAction, match=r"expected 0 \(forward\), 1 \(left\), 2 \(right\)"):
        env.step(action)
    two = raw_env(data=data, split="tiny", sensors=())
    two.reset()
    with pytest.raises(gymnasium.error.InvalidAction, match=r"expected 0 \(forward\)"):
        two.step(action)


def test_without_the_server_package(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(group: str) -> tuple[EntryPoint, ...]:
        assert group == "arramon.environments"
        return ()

    monkeypatch.setattr(players, "entry_points", none)
    players.local_backend.cache_clear()
    with pytest.raises(NoBackend, match=r"arramon-server is not installed: install it, or name a host with server="):
        gymnasium.make("arramon/ArraMon-v0")


def test_the_room_has_no_split() -> None:
    with pytest.raises(BadArgument, match="split is 'val_seen', but tasks in the room alone have no such argument"):
        gymnasium.make("arramon/ArraMonRoom-v0", split="val_seen")
    with pytest.raises(BadArgument, match="there is no language 'fr'; there are en, hi"):
        gymnasium.make("arramon/ArraMonRoom-v0", lang="fr")
    env = gymnasium.make("arramon/ArraMonRoom-v0", sensors=())
    with pytest.raises(BadArgument, match="there is no episode '7': the ids of drawn tasks are room-0, room-1"):
        env.reset(options={"episode": "7"})

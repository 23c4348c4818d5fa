"""Environments on a host: runs, what is forfeited, and what a host does not tell."""

import copy
import pickle
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import grpc
import gymnasium
import numpy as np
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.environments import BadArgument, remote
from arramon_client.environments.errors import CannotCopy
from arramon_client.errors import ServerUnreachableError
from tests import tiny
from tests.serving import METADATA, Server


@pytest.fixture(scope="module")
def server(data: Path) -> Iterator[Server]:
    server = Server(data, "127.0.0.1:0", "--steps", "8")
    yield server
    assert server.stop() == 0


@pytest.fixture
def stub(server: Server) -> Iterator[EvaluationStub]:
    with grpc.insecure_channel(server.address) as channel:
        yield EvaluationStub(channel)


def made(server: Server, **more: Any) -> Any:
    return gymnasium.make("arramon/ArraMon-v0", **{"server": server.address, "split": "tiny", "sensors": (), **more})


def run_of(stub: EvaluationStub, env: Any) -> pb.Run:
    return stub.GetRun(pb.GetRunRequest(run_id=env.unwrapped.player.run.run_id), metadata=METADATA)


def test_a_run_goes_through_the_split(server: Server, stub: EvaluationStub) -> None:
    env = made(server, lang="hi")
    ids = []
    for number in range(4):
        _, info = env.reset()
        ids.append(info["episode_id"])
        for action in tiny.ACTIONS:
            _, reward, terminated, _, info = env.step(action)
            assert reward == 0.0
        assert terminated
        assert info["cause"] == "AGENT_FINISHED"
        assert ("scores" in info) == (number == 3)  # The host tells them at the end of the run.
    assert sorted(ids) == ["1", "2", "4", "5"]
    run = run_of(stub, env)
    assert (run.state, run.agent, dict(run.causes)) == (pb.RUN_STATE_COMPLETE, "environment", {"AGENT_FINISHED": 4})
    _, info = env.reset()  # The next run.
    assert info["episode_id"] == ids[0]
    env.close()
    assert run_of(stub, env).state == pb.RUN_STATE_CANCELLED


def test_only_what_is_observed_is_asked_for(server: Server, stub: EvaluationStub) -> None:
    env = made(server, sensors=None, observe=("segmentation", "instruction_tokens", "turn"))
    observation, _ = env.reset(seed=np.int64(1))
    assert env.observation_space.contains(observation)
    assert observation["segmentation"].any()
    assert list(run_of(stub, env).sensors) == ["segmentation"]
    env.close()


def test_it_cannot_be_copied(server: Server) -> None:
    env = made(server)
    env.reset()
    for way in (pickle.dumps, copy.deepcopy, copy.copy):
        with pytest.raises(CannotCopy, match=rf"its run goes on at {server.address}: play in this process"):
            way(env.unwrapped)
    assert env.step(0)[0]["last_action"] == 0  # It goes on all the same.
    env.close()


def test_a_reset_before_the_end_forfeits(server: Server, stub: EvaluationStub) -> None:
    env = made(server)
    _, first = env.reset()
    env.step(0)
    _, second = env.reset()
    assert first["episode_id"] != second["episode_id"]
    run = run_of(stub, env)
    assert (run.episodes, run.episodes_ended, dict(run.causes)) == (6, 1, {"FORFEITED": 1})
    env.reset(options={"episode": "3"})  # A run of its own.
    assert run_of(stub, env).episodes == 1
    env.close()


def test_a_named_episode_is_a_run_with_scores(server: Server) -> None:
    env = made(server)
    for _ in range(2):
        values, _ = env.reset(options={"episode": "1"})
        assert (values["steps_left"][0], values["last_action"]) == (8, 4)
        for action in tiny.ACTIONS:
            *_, info = env.step(action)
        assert set(info["scores"]["total"].values()) == {1.0}
    env.close()


def test_a_hidden_split(server: Server) -> None:
    env = made(server, split="secret", sensors=("rgb",), image_size=128)
    values, _ = env.reset()
    assert values["rgb"].shape == (128, 128, 3)
    for action in tiny.ACTIONS:
        *_, info = env.step(action)
    assert info == {"phase_ended": "turn 2, assembly", "cause": "AGENT_FINISHED"}
    env.close()


def test_pictures_have_no_map(server: Server) -> None:
    env = made(server, sensors=("rgb",), render_mode="rgb_array")
    env.reset()
    picture = env.render()
    assert picture[:336, 336:].min() > 240
    env.close()


def test_many_at_once(server: Server) -> None:
    env: Any = gymnasium.make_vec(
        "arramon/ArraMon-v0", 2, server=server.address, split="tiny", sensors=("rgb", "depth")
    )
    values, infos = env.reset()
    assert infos["episode_id"][0] == infos["episode_id"][1]  # Each has a run of its own.
    assert (values["rgb"][0] == values["rgb"][1]).all()
    values, *_ = env.step(np.array([1, 2]))
    assert (values["rgb"][0] != values["rgb"][1]).any()
    env.close()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"lang": "fr"}, "the server has no language 'fr'; it has en, hi"),
        ({"split": "none"}, "the server has no split 'none'; it has secret, tiny"),
        ({"sensors": ("rgb",), "image_size": 64}, "the server does not offer images of 64 pixels; it offers 128, 224"),
        ({"split": "secret", "sensors": ("pose",)}, "'secret' does not offer the sensor 'pose'"),
        ({"steps_per_phase": 9}, "steps_per_phase is 9, but this host's step limit is 8"),
        ({"tokenizer": "words"}, "the words of the split 'tiny' in 'en' are not known"),
        ({"expert": "reference"}, "expert is 'reference', which a host does not support"),
        ({"turn": 2}, "turn is 2, which a host does not support"),
    ],
)
def test_bad_input(server: Server, given: dict[str, Any], message: str) -> None:
    with pytest.raises(BadArgument, match=message):
        made(server, **given)


def test_a_host_that_does_not_answer() -> None:
    with pytest.raises(ServerUnreachableError, match=r"no server answers at 127\.0\.0\.1:1"):
        gymnasium.make("arramon/ArraMon-v0", server="127.0.0.1:1", split="tiny")


def test_a_program_that_forgets_to_close_ends(server: Server) -> None:
    code = (
        "import sys, gymnasium, arramon_client.environments; "
        "env = gymnasium.make('ArraMon-v0', server=sys.argv[1], split='tiny', sensors=()); env.reset(); env.step(0)"
    )
    done = subprocess.run([sys.executable, "-c", code, server.address], timeout=120, check=False)
    assert done.returncode == 0


def test_a_host_that_goes_away_is_an_error(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remote, "PATIENCE", 1.0)
    host = Server(data, "127.0.0.1:0")
    env = made(host)
    env.reset()
    host.kill()
    with pytest.raises(ServerUnreachableError):
        env.step(0)
    env.close()

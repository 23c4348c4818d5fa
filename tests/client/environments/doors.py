"""The same actions through every way of playing an episode: what is seen, the scores and the hash chain."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import grpc
import gymnasium
import numpy as np

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.environments.backend import Player
from arramon_client.environments.two_agents import parallel_env, raw_env
from arramon_client.observations import observation_of
from arramon_client.transport.images import ImageDecoder
from arramon_client.world import PHASES
from tests.api.player import Player as Stream
from tests.api.player import create
from tests.serving import METADATA, Server

SENSORS = ("rgb", "depth", "segmentation", "pose")
STEPS = 8
"""The step limit: enough for `tiny.ACTIONS`."""

Seen = tuple[object, ...]


@dataclass
class Played:
    """One episode: what was seen before each action, the cause of its end, its scores, the head of its chain."""

    seen: list[Seen]
    cause: str
    scores: dict[str, Any]
    head: str
    run_id: str


Door = Callable[[Path, Server, str, Sequence[int], str], Played]
"""Plays episode 1 in a language with some actions; the last argument is the run that the chain is for."""


def over_grpc(server: Server, language: str, actions: Sequence[int]) -> Played:
    """The reference, without any of the client's environments: the stream itself, report and signed receipt."""
    with grpc.insecure_channel(server.address) as channel:
        stub = EvaluationStub(channel)
        run = create(stub, language=language, sensors=SENSORS, episode_ids=["1"])
        with Stream(stub, run.run_id) as stream:
            events = stream.play(actions)
        report = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
        receipt = stub.GetReceipt(pb.GetReceiptRequest(run_id=run.run_id), metadata=METADATA)
    decoder = ImageDecoder()
    seen: list[Seen] = []
    for event in events:
        if event.HasField("observation"):
            o = observation_of(event.observation, decoder)
            assert o.rgb is not None
            assert o.depth is not None
            assert o.segmentation is not None
            assert o.pose is not None
            images = o.rgb.tobytes(), o.depth.tobytes(), o.segmentation.tobytes()
            seen.append((o.turn, o.phase, o.steps_left, o.instruction, *images, o.pose))
    (episode,) = report.episodes
    turns = {row.name: {score.metric: score.mean for score in row.scores} for row in episode.turns}
    cause = types_pb2.Cause.Name(episode.cause).removeprefix("CAUSE_")
    (signed,) = json.loads(receipt.payload)["episodes"]
    return Played(seen, cause, turns, signed["head"], run.run_id)


def gymnasium_here(data: Path, server: Server, language: str, actions: Sequence[int], run_id: str) -> Played:
    return _gymnasium(actions, run_id, data=data, lang=language, steps_per_phase=STEPS)


def gymnasium_on_a_host(data: Path, server: Server, language: str, actions: Sequence[int], run_id: str) -> Played:
    return _gymnasium(actions, run_id, server=server.address, lang=language)


def vector(data: Path, server: Server, language: str, actions: Sequence[int], run_id: str) -> Played:
    return _vector(1, data, language, actions, run_id)


def vector_of_processes(data: Path, server: Server, language: str, actions: Sequence[int], run_id: str) -> Played:
    return _vector(2, data, language, actions, run_id)


def two_agents(data: Path, server: Server, language: str, actions: Sequence[int], run_id: str) -> Played:
    env = raw_env(**_arguments(data=data, lang=language, steps_per_phase=STEPS))
    env.reset(options={"episode": "1"})
    seen: list[Seen] = []
    taken = _repeated(actions)
    for agent in env.agent_iter():
        values, _, terminated, _, info = env.last()
        if terminated:
            played = _played(seen, info, env.player, run_id)
            break
        assert values["active"] == 1
        seen.append(_facts(values))
        assert PHASES[values["phase"]] == {"navigator": "navigation", "assembler": "assembly"}[agent]
        env.step(next(taken))
    env.close()
    return played


def two_agents_in_parallel(data: Path, server: Server, language: str, actions: Sequence[int], run_id: str) -> Played:
    env = parallel_env(**_arguments(data=data, lang=language, steps_per_phase=STEPS))
    values, _ = env.reset(options={"episode": "1"})
    seen: list[Seen] = []
    infos: dict[str, Any] = {}
    for action in _repeated(actions):
        if not env.agents:
            break
        (acting,) = [agent for agent in env.agents if values[agent]["active"]]
        seen.append(_facts(values[acting]))
        # What the other one does counts for nothing.
        values, _, _, _, infos = env.step({agent: action if agent == acting else 3 for agent in env.agents})
    played = _played(seen, infos["navigator"], env.player, run_id)
    env.close()
    return played


DOORS = (
    gymnasium_here, gymnasium_on_a_host, vector, vector_of_processes, two_agents, two_agents_in_parallel,
)  # fmt: skip


def _arguments(**more: object) -> dict[str, Any]:
    return {"split": "tiny", "sensors": SENSORS, "image_size": 224, **more}


def _repeated(actions: Sequence[int]) -> Iterator[int]:
    step = 0
    while True:
        yield int(actions[step % len(actions)])
        step += 1


def _facts(values: dict[str, Any]) -> Seen:
    images = (values[name].tobytes() for name in ("rgb", "depth", "segmentation"))
    pose = tuple(float(each) for each in values["pose"])
    phase, left = PHASES[int(values["phase"])], int(values["steps_left"][0])
    return (int(values["turn"]), phase, left, values["instruction"], *images, pose)


def _played(seen: list[Seen], info: dict[str, Any], player: Player, run_id: str) -> Played:
    scores = {name: info["scores"][name] for name in ("turn 1", "turn 2")}
    return Played(seen, info["cause"], scores, player.chain_head(run_id).hex(), run_id)


def _gymnasium(actions: Sequence[int], run_id: str, **arguments: object) -> Played:
    env = gymnasium.make("arramon/ArraMon-v0", **_arguments(**arguments))
    values, _ = env.reset(options={"episode": "1"})
    seen, terminated, taken = [], False, _repeated(actions)
    while not terminated:
        seen.append(_facts(values))
        action = next(taken)
        before = values
        values, _, terminated, truncated, info = env.step(action)
        assert not truncated
        assert values["last_action"] == action
    assert _facts(values) == _facts(before)  # Nothing is drawn after the end.
    played = _played(seen, info, env.unwrapped.player, run_id)  # type: ignore[attr-defined]
    env.close()
    return played


def _vector(processes: int, data: Path, language: str, actions: Sequence[int], run_id: str) -> Played:
    """The first of three episodes at once; the others take other actions."""
    arguments = _arguments(data=data, lang=language, steps_per_phase=STEPS)
    env: Any = gymnasium.make_vec(
        "arramon/ArraMon-v0", num_envs=3, processes=processes, autoreset_mode="Disabled", **arguments
    )
    # With two processes the first one plays row 0, the other one rows 1 and 2.
    row = processes - 1
    ids = ["2", "4", "4"]
    ids[row] = "1"
    values, _ = env.reset(options={"episode": ids})
    seen, terminated, taken, others = [], np.zeros(3, bool), _repeated(actions), 0
    while not terminated[row]:
        seen.append(_facts(_row(values, row)))
        chosen = np.full(3, others % 3)
        chosen[row] = next(taken)
        values, _, terminated, _, infos = env.step(chosen)
        others += 1
        rest = terminated.copy()
        rest[row] = False
        if rest.any():
            values, _ = env.reset(options={"reset_mask": rest, "episode": "4"})
    scores = {
        turn: {metric: value[row] for metric, value in infos["scores"][turn].items() if not metric.startswith("_")}
        for turn in ("turn 1", "turn 2")
    }
    head = env.heads(run_id)[row].hex()
    env.close()
    return Played(seen, infos["cause"][row], scores, head, run_id)


def _row(values: dict[str, Any], row: int) -> dict[str, Any]:
    return {name: value[row] for name, value in values.items()}

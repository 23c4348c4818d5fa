"""Duplicate, late, early and unordered actions."""

import random
from pathlib import Path

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests import tiny
from tests.api.player import Player, create
from tests.serving import METADATA, Server

EPISODES = 6


def report(stub: EvaluationStub, run: pb.Run) -> tuple[list[pb.Row], list[pb.EpisodeScores]]:
    answer = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    return list(answer.rows), list(answer.episodes)


def played_in_disorder(stub: EvaluationStub, chance: random.Random) -> tuple[pb.Run, int]:
    """A run along the ground truth, each answer among others that must not count; and the problems reported."""
    run = create(stub)
    problems = 0
    with Player(stub, run.run_id, EPISODES) as player:
        said: set[tuple[str, int]] = set()
        while True:
            event = player.next()
            match event.WhichOneof("event"):
                case "run_ended":
                    return run, problems
                case "problem":
                    problems += 1
                case "observation":
                    at, step = event.observation.episode_id, event.observation.step
                    if (at, step) in said:
                        continue  # told again, as an answer came again
                    said.add((at, step))
                    right = pb.Act(episode_id=at, step=step, action=types_pb2.Action.ValueType(tiny.ACTIONS[step]))
                    early = pb.Act(episode_id=at, step=step + 2, action=types_pb2.ACTION_LEFT)
                    late = [
                        pb.Act(episode_id=at, step=earlier, action=types_pb2.ACTION_INTERACT)
                        for earlier in range(max(0, step - 2), step)
                    ]
                    others = [early, *late]
                    chance.shuffle(others)
                    player.send([*others, right, right, *others])


def test_only_the_first_answer_to_each_observation_counts(tmp_path: Path) -> None:
    tiny.write(tmp_path, count=EPISODES)
    server = Server(tmp_path, "127.0.0.1:0")
    with grpc.insecure_channel(server.address) as channel:
        stub = EvaluationStub(channel)
        once = create(stub)
        with Player(stub, once.run_id, EPISODES) as player:
            player.play(tiny.ACTIONS)
        again, problems = played_in_disorder(stub, random.Random(1))
        assert report(stub, again) == report(stub, once)
        assert problems > EPISODES * len(tiny.ACTIONS)
    assert server.stop() == 0

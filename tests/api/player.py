"""A minimal Play client: opens a stream, sends given messages, and returns events one by one."""

from __future__ import annotations

from collections.abc import Iterable
from queue import SimpleQueue
from types import TracebackType

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests import tiny
from tests.serving import METADATA


def create(stub: EvaluationStub, **fields: object) -> pb.Run:
    request = pb.CreateRunRequest(agent="test", split="tiny", language="en")
    for name, value in fields.items():
        request.MergeFrom(pb.CreateRunRequest(**{name: value}))  # type: ignore[arg-type]
    return stub.CreateRun(request, metadata=METADATA)


def played(stub: EvaluationStub, actions: Iterable[int] = tiny.ACTIONS, **fields: object) -> pb.Run:
    """A run that is over."""
    with Player(stub, create(stub, **fields).run_id, 3) as player:
        return player.play(actions)[-1].run_ended.run


STREAM_SECONDS = 240.0
"""After which a stream is given up that would never end; no test waits for it."""


class Player:
    """One Play stream."""

    def __init__(self, stub: EvaluationStub, run_id: str, episodes: int = 1, **fields: object) -> None:
        self._asked: SimpleQueue[pb.PlayRequest | None] = SimpleQueue()
        opening = pb.Open(run_id=run_id, max_episodes=episodes, **fields)  # type: ignore[arg-type]
        self._asked.put(pb.PlayRequest(open=opening))
        self.call = stub.Play(iter(self._asked.get, None), metadata=METADATA, timeout=STREAM_SECONDS)
        self._events = (event for response in self.call for event in response.events)

    def __enter__(self) -> Player:
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._asked.put(None)
        self.call.cancel()

    def act(self, episode_id: str, step: int, action: int) -> None:
        self.send([pb.Act(episode_id=episode_id, step=step, action=action)])  # type: ignore[arg-type]

    def send(self, acts: Iterable[pb.Act]) -> None:
        self._asked.put(pb.PlayRequest(actions=pb.ActionBatch(acts=acts)))

    def raw(self, request: pb.PlayRequest) -> None:
        self._asked.put(request)

    def next(self) -> pb.Event:
        return next(self._events)

    def observation(self) -> pb.Observation:
        """The next observation; anything else before it is passed over, but for problems."""
        while True:
            event = self.next()
            assert event.WhichOneof("event") not in ("problem", "run_ended"), event
            if event.WhichOneof("event") == "observation":
                return event.observation

    def problem(self) -> pb.Problem:
        event = self.next()
        assert event.WhichOneof("event") == "problem", event
        return event.problem

    def play(self, actions: Iterable[int]) -> list[pb.Event]:
        """Plays every episode offered with the same actions, in order, until the run ends; returns all events."""
        actions, events = list(actions), []
        for event in self._events:
            events.append(event)
            if event.WhichOneof("event") == "observation" and not event.observation.HasField("taken"):
                step = event.observation.step
                self.act(event.observation.episode_id, step, actions[step % len(actions)])
        return events


FORWARD, LEFT = types_pb2.ACTION_FORWARD, types_pb2.ACTION_LEFT

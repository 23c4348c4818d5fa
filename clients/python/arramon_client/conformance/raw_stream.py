"""A raw Play stream, which can send any message, and returns events one by one, each within a time limit."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any

import grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client.conformance.assertions import Violation, expect

MAX_QUEUED = 4096
"""Maximum number of events that wait to be returned; reading from the stream pauses at this limit."""

Metadata = tuple[tuple[str, str | bytes], ...]


class RawStream:
    """One Play stream, a context manager that cancels the stream at its end.

    Args:
        stub: stub of the server under test.
        first: the first message.
        timeout: seconds to wait for each event.
        metadata: metadata of the call.
    """

    def __init__(self, stub: EvaluationStub, first: pb.PlayRequest, *, timeout: float, metadata: Metadata) -> None:
        self._timeout = timeout
        self._outbox: queue.SimpleQueue[pb.PlayRequest | None] = queue.SimpleQueue()
        self._inbox: queue.Queue[pb.Event | grpc.RpcError | None] = queue.Queue(MAX_QUEUED)
        self._outbox.put(first)
        self._call = stub.Play(iter(self._outbox.get, None), metadata=metadata)
        self._reader = threading.Thread(target=self._read, name="conformance-play", daemon=True)
        self._reader.start()

    def __enter__(self) -> RawStream:
        return self

    def __exit__(self, *_: object) -> None:
        self._call.cancel()
        self._outbox.put(None)
        while self._reader.is_alive():  # The thread may be waiting for a free slot in the queue.
            with suppress(queue.Empty):
                self._inbox.get(timeout=0.01)

    def send(self, *acts: pb.Act) -> None:
        """Send one message with these acts."""
        self.send_raw(pb.PlayRequest(actions=pb.ActionBatch(acts=acts)))

    def send_raw(self, request: pb.PlayRequest) -> None:
        """Send a message as it is."""
        self._outbox.put(request)

    def act(self, seen: pb.Observation, action: types_pb2.Action.ValueType) -> None:
        """Answer an observation."""
        self.send(pb.Act(episode_id=seen.episode_id, step=seen.step, action=action))

    def event(self) -> pb.Event | None:
        """Return the next event; None at the end of a stream that the server closed without an error.

        Raises:
            grpc.RpcError: if the server closed the stream with an error.
            Violation: if no event arrives in time.
        """
        try:
            item = self._inbox.get(timeout=self._timeout)
        except queue.Empty:
            raise Violation(f"nothing came on the stream for {self._timeout:g} seconds, expected an event") from None
        if isinstance(item, grpc.RpcError):
            raise item
        return item

    def rest(self) -> Iterator[pb.Event]:
        """Yield all events up to the end of the stream.

        Raises:
            grpc.RpcError: if the server closed the stream with an error.
            Violation: if no event arrives in time, and the stream does not end.
        """
        return iter(self.event, None)

    def next(self, kind: str, passing: Sequence[str] = ()) -> Any:
        """Return the content of the next event, which must be of the given kind.

        Args:
            kind: name of a field of `Event`.
            passing: kinds of events that may precede it and are skipped.

        Raises:
            grpc.RpcError, Violation: if another event arrives.
        """
        while True:
            event = self.event()
            found: str = (event.WhichOneof("event") or "an empty event") if event is not None else "its end"
            if event is not None and found == kind:
                return getattr(event, kind)
            more = f" ({event.problem.message})" if event is not None and found == "problem" else ""
            expect(found in passing, f"the stream sent {found}{more}, expected {kind}")

    def begin(self) -> tuple[pb.Opened, pb.EpisodeStarted, pb.Observation]:
        """Return the first three events of a stream that gets an episode."""
        return self.next("opened"), self.next("episode_started"), self.next("observation")

    def observation(self) -> pb.Observation:
        """Return the next observation, skipping starts of episodes and ends of phases."""
        seen: pb.Observation = self.next("observation", ("episode_started", "phase_ended"))
        return seen

    def problem(self, code: pb.Problem.Code.ValueType, episode_id: str) -> None:
        """Check that the next event is a problem with this code, for this episode, with a message."""
        problem = self.next("problem")
        names = pb.Problem.Code
        expect(problem.code == code, f"the problem is {names.Name(problem.code)}, expected {names.Name(code)}")
        expect(problem.message.strip(), f"the problem {names.Name(code)} has no message, expected what was wrong")
        expect(
            problem.episode_id == episode_id,
            f"the problem names the episode {problem.episode_id!r}, expected {episode_id!r}",
        )

    def _read(self) -> None:
        end: grpc.RpcError | None = None
        try:
            for response in self._call:
                for event in response.events:
                    self._inbox.put(event)
        except grpc.RpcError as error:
            end = error
        self._inbox.put(end)


def without_clocks(seen: pb.Observation, *more: str) -> pb.Observation:
    """Return an observation without its clock fields, which differ each time, and without these further fields."""
    copy = pb.Observation()
    copy.CopyFrom(seen)
    for name in ("step_seconds_left", "bank_seconds_left", *more):
        copy.ClearField(name)  # type: ignore[arg-type]
    return copy


def forfeit(episode_id: str) -> pb.Act:
    """Return the act that forfeits an episode."""
    return pb.Act(episode_id=episode_id, forfeit=pb.Forfeit(reason="conformance check"))

"""A Play stream, read by a separate thread, so that all events that have arrived can be processed as one batch.

With at most one open episode nothing arrives while the agent computes, so no thread is used: waking it up at every step
would be slow.
"""

import queue
import threading
from collections.abc import Sequence

import grpc

from arramon.v1 import evaluation_pb2, evaluation_pb2_grpc
from arramon_client.stopping import SIGNAL_SECONDS
from arramon_client.transport.connection import METADATA

MAX_QUEUED = 16
"""Capacity of the queue of responses; reading pauses when it is full, so that a long history does not fill memory."""

ACTS_IN_MESSAGE = 256
"""Maximum number of acts in one message; with the longest notes they take half of the 1 MiB that servers accept by
default."""


class StreamEnded(Exception):
    """The server ended the stream without an error, for example because it is shutting down."""


class PlayStream:
    """An open Play stream, which must be closed.

    Args:
        stub: stub of the server.
        opening: the first message.
        reads_ahead: whether a thread reads messages while the caller is busy; None: with several open episodes.

    Attributes:
        was_answered: whether the server has sent anything on this stream.
    """

    def __init__(
        self,
        stub: evaluation_pb2_grpc.EvaluationStub,
        opening: evaluation_pb2.Open,
        *,
        reads_ahead: bool | None = None,
    ) -> None:
        self.was_answered = False
        self._outgoing = _Requests()
        self._incoming: queue.Queue[evaluation_pb2.PlayResponse | grpc.RpcError | None] = queue.Queue(MAX_QUEUED)
        self._outgoing.put(evaluation_pb2.PlayRequest(open=opening))
        self._call = stub.Play(self._outgoing, metadata=METADATA)
        self._reader: threading.Thread | None = None
        if opening.max_episodes > 1 if reads_ahead is None else reads_ahead:
            self._reader = threading.Thread(target=self._read, name="arramon-play", daemon=True)
            self._reader.start()

    def receive(self, *, wait: bool) -> list[evaluation_pb2.Event]:
        """Return the events that have arrived, in order.

        Args:
            wait: whether to wait for at least one message; the message may be empty.

        Raises:
            grpc.RpcError: if the stream broke; earlier calls have returned everything that arrived before.
            StreamEnded: if the server ended the stream.
        """
        if self._reader is None:
            return self._read_one() if wait else []
        events: list[evaluation_pb2.Event] = []
        for taken in range(MAX_QUEUED):
            try:
                response = self._wait_for_message() if wait and not taken else self._incoming.get(block=False)
            except queue.Empty:
                break
            if isinstance(response, evaluation_pb2.PlayResponse):
                events.extend(response.events)
                continue
            if not taken:
                raise StreamEnded if response is None else response
            self._incoming.put(response)  # Return the events first; the next call raises the end.
            break
        return events

    def _wait_for_message(self) -> evaluation_pb2.PlayResponse | grpc.RpcError | None:
        """Wait for a message, in pieces, so that a signal takes effect."""
        while True:
            try:
                return self._incoming.get(timeout=SIGNAL_SECONDS)
            except queue.Empty:
                continue

    def send(self, acts: Sequence[evaluation_pb2.Act]) -> None:
        """Send one batch of acts, in several messages if its notes would make one too large for a server."""
        for start in range(0, len(acts), ACTS_IN_MESSAGE):
            batch = evaluation_pb2.ActionBatch(acts=acts[start : start + ACTS_IN_MESSAGE])
            self._outgoing.put(evaluation_pb2.PlayRequest(actions=batch))

    def cancel(self) -> None:
        """Cancel the stream from another thread; a waiting `receive` then raises the error."""
        self._call.cancel()

    def close(self) -> None:
        """Cancel the stream, and stop its reader thread if there is one."""
        self._call.cancel()
        self._outgoing.put(None)
        while self._reader is not None and self._reader.is_alive():
            try:
                self._incoming.get(timeout=0.01)
            except queue.Empty:
                self._reader.join(timeout=0.01)

    def _read_one(self) -> list[evaluation_pb2.Event]:
        try:
            response = next(self._call)
        except StopIteration:
            raise StreamEnded from None
        self.was_answered = True
        return list(response.events)

    def _read(self) -> None:
        end: grpc.RpcError | None = None
        try:
            for response in self._call:
                self.was_answered = True
                self._incoming.put(response)
        except grpc.RpcError as error:
            end = error
        self._incoming.put(end)


class _Requests:
    """Iterator over requests that other threads add, for gRPC; acts that wait at the same time share a message.

    A message costs more than an act, and episodes that are played at their own pace send one act at a time.
    """

    def __init__(self) -> None:
        self._queue: queue.SimpleQueue[evaluation_pb2.PlayRequest | None] = queue.SimpleQueue()
        self._next: list[evaluation_pb2.PlayRequest | None] = []  # A request that did not fit into the message before.

    def put(self, request: evaluation_pb2.PlayRequest | None) -> None:
        """Add a request; None for the end."""
        self._queue.put(request)

    def __iter__(self) -> "_Requests":
        return self

    def __next__(self) -> evaluation_pb2.PlayRequest:
        request = self._next.pop() if self._next else self._queue.get()
        if request is None:
            raise StopIteration
        acts = request.actions.acts
        while acts:
            try:
                following = self._queue.get(block=False)
            except queue.Empty:
                break
            if following is None or len(acts) + len(following.actions.acts) > ACTS_IN_MESSAGE:
                self._next.append(following)
                break
            acts.extend(following.actions.acts)
        return request

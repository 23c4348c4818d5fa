"""One Play stream: what arrives is read by a thread of its own, so that all that has arrived can be taken at once.

Where one episode is open at the most, nothing arrives while the agent thinks. Then who waits for the server reads
itself: to wake another thread with every step would be dear.
"""

import queue
import threading
from collections.abc import Sequence

import grpc

from arramon.v1 import evaluation_pb2, evaluation_pb2_grpc
from arramon_client.connection import METADATA

WAITING = 16
"""Responses that wait to be taken; then the server is held back, so that a long history does not fill the memory."""


class StreamEnded(Exception):
    """The server ended the stream in good order, as one does that drains."""


class PlayStream:
    """An open Play stream. Close it at the end, whatever happened."""

    def __init__(self, stub: evaluation_pb2_grpc.EvaluationStub, opening: evaluation_pb2.Open) -> None:
        self._outgoing: queue.SimpleQueue[evaluation_pb2.PlayRequest | None] = queue.SimpleQueue()
        self._incoming: queue.Queue[evaluation_pb2.PlayResponse | grpc.RpcError | None] = queue.Queue(WAITING)
        self._outgoing.put(evaluation_pb2.PlayRequest(open=opening))
        self._call = stub.Play(iter(self._outgoing.get, None), metadata=METADATA)
        self._reader: threading.Thread | None = None
        if opening.max_episodes > 1:
            self._reader = threading.Thread(target=self._read, name="arramon-play", daemon=True)
            self._reader.start()

    def receive(self, *, wait: bool) -> list[evaluation_pb2.Event]:
        """The events that have arrived, in order; none at most where the server sent an empty message.

        Args:
            wait: whether to wait until there is at least one message.

        Raises:
            grpc.RpcError: if the stream broke; everything that arrived before was returned by the calls before.
            StreamEnded: if the server ended it.
        """
        if self._reader is None:
            return self._read_one() if wait else []
        events: list[evaluation_pb2.Event] = []
        for taken in range(WAITING):
            try:
                response = self._incoming.get(block=wait and not taken)
            except queue.Empty:
                break
            if isinstance(response, evaluation_pb2.PlayResponse):
                events.extend(response.events)
                continue
            if not taken:
                raise StreamEnded if response is None else response
            self._incoming.put(response)  # First what arrived; the next call finds the end again.
            break
        return events

    def send(self, acts: Sequence[evaluation_pb2.Act]) -> None:
        """Sends one batch of actions."""
        self._outgoing.put(evaluation_pb2.PlayRequest(actions=evaluation_pb2.ActionBatch(acts=acts)))

    def close(self) -> None:
        """Ends the stream, and the thread that reads it, if there is one."""
        self._call.cancel()
        self._outgoing.put(None)
        while self._reader is not None and self._reader.is_alive():
            try:
                self._incoming.get(timeout=0.01)
            except queue.Empty:
                self._reader.join(timeout=0.01)

    def _read_one(self) -> list[evaluation_pb2.Event]:
        try:
            return list(next(self._call).events)
        except StopIteration:
            raise StreamEnded from None

    def _read(self) -> None:
        end: grpc.RpcError | None = None
        try:
            for response in self._call:
                self._incoming.put(response)
        except grpc.RpcError as error:
            end = error
        self._incoming.put(end)

"""The streams of one player, one after the other: opened, and opened again when one breaks, until the run has ended."""

import threading
import uuid
from collections.abc import Callable
from dataclasses import replace

import grpc

from arramon.v1 import evaluation_pb2, evaluation_pb2_grpc, types_pb2
from arramon_client.errors import ProtocolError
from arramon_client.player import Player
from arramon_client.settings import Settings
from arramon_client.transport.connection import CONNECTION_LOST, explain
from arramon_client.transport.images import ImagesUnreadableError
from arramon_client.transport.incoming import details_of
from arramon_client.transport.retry import Retry
from arramon_client.transport.stream import PlayStream, StreamEnded

BACKLOG = 256
"""Maximum number of observations that wait for an answer; reading from the stream pauses at this limit."""


class PlayerStreams:
    """The streams of one player.

    Args:
        stub: stub of the server.
        player: the player.
        settings: settings of the session.
        address: address of the server, for messages.
        notify: called with messages for the participant.
        revive: called before each attempt to reconnect, for example to restart an embedded server.
        reads_ahead: as for `PlayStream`.

    Attributes:
        retry: delays between attempts to reconnect.
        reconnections: number of times that the stream was reopened.
    """

    def __init__(
        self,
        stub: evaluation_pb2_grpc.EvaluationStub,
        player: Player,
        settings: Settings,
        *,
        address: str,
        notify: Callable[[str], None],
        revive: Callable[[], None],
        reads_ahead: bool | None = None,
    ) -> None:
        self._stub, self._player, self._settings = stub, player, settings
        self._address, self._notify, self._revive, self._reads_ahead = address, notify, revive, reads_ahead
        self._name = uuid.uuid4().hex
        self._stopped = threading.Event()
        self._stream: PlayStream | None = None
        self.retry = Retry(player.run.run_id, settings.patience, notify, self._sleep)
        self.reconnections = 0

    def play(self, use: Callable[[PlayStream], None]) -> None:
        """Open streams until the run has ended or `stop` is called.

        Args:
            use: passes events and acts between a stream and the player, until the run has ended or another stream is
                needed. What it raises when the stream breaks or ends leads to another stream.

        Raises:
            ServerUnreachableError: if the server is away for longer than the patience; the run can be resumed.
            RefusedError, VersionMismatchError, MessageTooLargeError: if the server refuses the stream.
            ProtocolError: if client or server violates the protocol.
        """
        player, adopt = self._player, self._settings.resume
        while not self._stopped.is_set():
            before = player.advances
            broken, quiet = self._play_one(use, adopt=adopt)
            if player.ended or self._stopped.is_set():
                return
            adopt = adopt and player.advances == before
            self.reconnections += 1
            if broken:
                self.retry.wait(broken, quiet=quiet)
                if not self._stopped.is_set():
                    self._revive()

    @property
    def stopped(self) -> bool:
        """Whether `stop` was called."""
        return self._stopped.is_set()

    def stop(self) -> None:
        """End `play` from another thread: cancel the stream, and open no further one."""
        self._stopped.set()
        stream = self._stream
        if stream is not None:
            stream.cancel()

    def _sleep(self, seconds: float) -> None:
        self._stopped.wait(seconds)

    def _play_one(self, use: Callable[[PlayStream], None], *, adopt: bool) -> tuple[str, bool]:
        """Play over one stream; return why it broke (empty if it did not), and whether that is to be expected.

        A server process that drains ends its streams without an error, and gRPC refuses those that reach it meanwhile.
        """
        player, settings = self._player, self._settings
        history = adopt or player.needs_history
        stream = self._stream = PlayStream(self._stub, self._opening(history, adopt), reads_ahead=self._reads_ahead)
        try:
            if self._stopped.is_set():  # `stop` may have been called before it could find this stream.
                return "", False
            is_shared = settings.encoding == types_pb2.ENCODING_SHARED
            player.start_stream(history=history, max_episodes=settings.parallel, shared=is_shared)
            use(stream)
        except ImagesUnreadableError as error:
            if settings.encoding == types_pb2.ENCODING_RAW:
                raise ProtocolError(f"the server uses an encoding that was not requested: {error}") from error
            self._notify(f"images are sent in messages: {error}")
            self._settings = replace(settings, encoding=types_pb2.ENCODING_RAW)
        except StreamEnded:
            return "the server closed the stream", True
        except grpc.RpcError as error:
            if error.code() not in CONNECTION_LOST:
                raise explain(error, self._address) from error
            return f"{error.code().name}: {details_of(error)}", not stream.was_answered
        finally:
            self._stream = None
            stream.close()
        return "", False

    def _opening(self, history: bool, adopt: bool) -> evaluation_pb2.Open:
        return evaluation_pb2.Open(
            run_id=self._player.run.run_id,
            player=self._name,
            max_episodes=self._settings.parallel,
            encoding=self._settings.encoding,
            jpeg_quality=self._settings.jpeg_quality,
            image_size=self._settings.image_size,
            history=history,
            adopt=adopt,
        )

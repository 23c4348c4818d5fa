"""The interface through which the engine encodes and sends the events of one stream."""

from collections.abc import Sequence
from typing import Protocol

from arramon_server.errors import ArraMonError
from arramon_server.runs.play.events import Encoding, Event, Observed
from arramon_server.sim.cameras import Frame


class Transport(Protocol):
    """Encodes and sends the events of one stream."""

    @property
    def compresses(self) -> bool:
        """Whether frames are compressed in the threads that would otherwise draw; they are then drawn one by one."""

    @property
    def backlog(self) -> int:
        """Number of bytes that were given to `send` and have not left the server."""

    def canvas(self, episode_id: str) -> Frame | None:
        """Return the frame into which an episode's latest observation is drawn; None for a new frame."""

    def begin_encoding(self, event: Observed) -> Encoding:
        """Begin to compress an observation's images in the threads, while the next one is drawn."""

    def send(self, events: Sequence[Event]) -> None:
        """Send events, in one message."""

    def close(self, error: ArraMonError | None) -> None:
        """End the stream after everything that was sent, with an error or without."""

"""One client's stream, as the engine sees it: what it plays, what it asked, and what it is still to be told."""

import asyncio
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from server.errors import ArraMonError
from server.runs.events import EpisodeEnded, Event
from server.runs.records import Run
from server.runs.session import Session

IMAGES = frozenset(("rgb", "depth", "segmentation"))
"""Sensors for which a frame must be drawn."""


MAX_ASKED = 16
"""Batches of acts waiting to be played, from which on no more are read."""


@dataclass(frozen=True, slots=True)
class Act:
    """An agent's answer to one observation.

    Attributes:
        step: of the observation.
        action: None where the client sent none; any number, checked by the engine.
        forfeit: the reason why the episode is given up, None where it is not.
    """

    episode_id: str
    step: int
    action: int | None = None
    forfeit: str | None = None


@dataclass(eq=False)
class Stream:
    """A stream that joined a run.

    Attributes:
        run: that it plays.
        player: its client's own name for it, kept over reconnections.
        max_episodes: to have open at once.
        image_size: side length of the images, in pixels.
        images: in which form they travel, such as "lossless-224"; empty where there are none.
        history: whether its agent needs each open episode from the first observation on.
        adopt: whether it takes over what other players left open at once.
        deliver: takes events to the client.
        close: ends the stream, with an error or without.
        backlog: how many deliveries have not left yet.
        asked: batches of acts that came in.
        told: events to deliver, observations among them not drawn yet.
        sessions: its open episodes.
        ended: what it was told at the end of its ended ones.
    """

    run: Run
    player: str
    max_episodes: int
    image_size: int
    images: str
    history: bool
    adopt: bool
    deliver: Callable[[Sequence[Event]], None]
    close: Callable[[ArraMonError | None], None]
    backlog: Callable[[], int]
    asked: deque[Sequence[Act]] = field(default_factory=deque)
    told: deque[Event] = field(default_factory=deque)
    sessions: dict[str, Session] = field(default_factory=dict)
    ended: dict[str, EpisodeEnded] = field(default_factory=dict)
    _taken: asyncio.Event = field(default_factory=asyncio.Event)

    def take(self) -> Sequence[Act]:
        """The batch of acts that came in first."""
        self._taken.set()
        return self.asked.popleft()

    async def wait_for_room(self) -> None:
        """Waits while too much that was asked lies here: a client that sends faster than it is played is held back."""
        while len(self.asked) >= MAX_ASKED:
            self._taken.clear()
            await self._taken.wait()

    @property
    def sees(self) -> bool:
        """Whether its run asked for images."""
        return not IMAGES.isdisjoint(self.run.sensors)

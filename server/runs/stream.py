"""One client's stream, as the engine sees it: what it plays, what it asked, and what it is still to be told."""

import asyncio
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from server.errors import ArraMonError
from server.runs.clocks import StreamClock
from server.runs.events import EpisodeEnded, Event
from server.runs.records import OPEN, Claim, Run
from server.runs.session import Session

IMAGES = frozenset(("rgb", "depth", "segmentation"))
"""Sensors for which a frame must be drawn."""


MAX_ASKED = 16
"""Batches of acts waiting to be played, from which on no more are read."""


MAX_TOLD = 8192
"""Events to be told, from which on nothing more that was asked is played. A stream's open episodes ask far fewer."""


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


class Asked(NamedTuple):
    """A batch of acts, and when it came in."""

    at: float
    acts: Sequence[Act]


class Coming(NamedTuple):
    """An episode that is a stream's and is still to be opened; `with_past` if it is told all that was played of it."""

    claim: Claim
    with_past: bool


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
        backlog: how many bytes of deliveries have not left yet.
        clock: of its episodes; None where its run has none.
        asked: batches of acts that came in.
        told: events to deliver, observations among them not drawn yet.
        sessions: its open episodes.
        coming: those that are still to be opened for it, by id, in order: long ones take a while.
        opening: goes on with the first of these; None where it was not begun.
        since: when it asked what it has not been told all of, by its clock; None where there is nothing.
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
    clock: StreamClock | None = None
    asked: deque[Asked] = field(default_factory=deque)
    told: deque[Event] = field(default_factory=deque)
    sessions: dict[str, Session] = field(default_factory=dict)
    coming: dict[str, Coming] = field(default_factory=dict)
    opening: Iterator[None] | None = None
    since: float | None = None
    ended: dict[str, EpisodeEnded] = field(default_factory=dict)
    _taken: asyncio.Event = field(default_factory=asyncio.Event)

    @property
    def is_asking(self) -> bool:
        """Whether there is something to answer, and room for the answers: who does not read is not answered further."""
        return bool(self.asked) and len(self.told) < MAX_TOLD

    @property
    def can_open(self) -> bool:
        """Whether there is an episode to open, and room for what is to be told of it."""
        return bool(self.coming) and len(self.told) < MAX_TOLD

    @property
    def room(self) -> int:
        """How many more episodes it takes."""
        return self.max_episodes - len(self.sessions) - len(self.coming)

    def claim(self, session: Session) -> Claim:
        """Under which an episode is open here."""
        return Claim(session.episode.episode_id, OPEN, self.player, session.epoch)

    def claim_of(self, episode_id: str) -> Claim:
        """As `claim`; of an episode that is not open here, one that nobody holds."""
        session = self.sessions.get(episode_id)
        return Claim(episode_id, OPEN, self.player, session.epoch if session else -1)

    def drop(self, episode_id: str) -> None:
        """An episode is not the stream's any more."""
        self.sessions.pop(episode_id, None)
        if self.coming.pop(episode_id, None) is not None:
            self.opening = None  # only the first of them is ever begun
        if self.clock is not None:
            self.clock.close(episode_id)

    def take(self) -> Asked:
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

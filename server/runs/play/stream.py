"""One client's stream as the engine sees it: its open episodes, the actions that arrived, the events to deliver."""

import asyncio
import time
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from arramon_server.runs.play.clocks import StreamClock
from arramon_server.runs.play.events import Event, RunEnded
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.transport import Transport
from arramon_server.runs.storage.records import OPEN, Claim, Run

IMAGES = frozenset(("rgb", "depth", "segmentation"))
"""Sensors for which a frame must be drawn."""

MAX_INBOX = 16
"""Queued messages of actions above which no further message is read from the stream."""

MAX_BATCH = 16
"""Limit of the observations of one message, and of the actions for which a stream waits."""

GATHER_SECONDS = 0.002
"""Longest time for which an action waits for others of its stream."""

MAX_BACKLOG = 2 << 20
"""Unsent bytes above which nothing more is drawn for a stream: about eight raw observations."""

MAX_OUTBOX = 8192
"""Queued events above which no further actions are applied. The open episodes of a stream need far fewer."""


@dataclass(frozen=True, slots=True)
class Act:
    """An agent's answer to one observation.

    Attributes:
        step: number of the observation.
        action: as it was sent, checked by the engine; None if there was none.
        forfeit: why the episode is given up; None if it is not.
    """

    episode_id: str
    step: int
    action: int | None = None
    forfeit: str | None = None


class ActionBatch(NamedTuple):
    """The actions of one message, and when it arrived, in seconds of the clock of play."""

    at: float
    acts: Sequence[Act]


class AssignedEpisode(NamedTuple):
    """An episode that is claimed for a stream and not open yet.

    Attributes:
        claim: under which it will be open.
        with_history: whether its earlier observations are delivered too.
    """

    claim: Claim
    with_history: bool


@dataclass(eq=False)
class Stream:
    """A stream that joined a run.

    Attributes:
        run: that it plays.
        player: the client's own name for itself, kept over reconnections.
        max_episodes: to have open at once.
        image_size: side length of the images, in pixels.
        images: encoding and size of the images, such as "lossless-224"; empty without images.
        history: whether the agent needs each open episode from its first observation on.
        adopt: whether to take over at once what other players left open.
        transport: encodes and sends the events.
        clock: of its episodes; None if the run has no clocks.
        inbox: messages of actions that arrived, oldest first; `ask` adds to them.
        due: time by `time.monotonic` at which they are applied even if few have arrived.
        outbox: events to deliver; their frames are not drawn yet.
        sessions: open episodes by id.
        assigned: episodes still to be opened, by id, in order.
        opening: the opening of the first of these, in progress; None if it has not begun.
        oldest_arrival: arrival of the oldest actions that are not fully answered, by its clock; None if there are none.
        ended: ids of episodes whose end it was told: late answers to them are ignored.
    """

    run: Run
    player: str
    max_episodes: int
    image_size: int
    images: str
    history: bool
    adopt: bool
    transport: Transport
    clock: StreamClock | None = None
    inbox: deque[ActionBatch] = field(default_factory=deque)
    due: float = 0.0
    outbox: deque[Event] = field(default_factory=deque)
    sessions: dict[str, EpisodeSession] = field(default_factory=dict)
    assigned: dict[str, AssignedEpisode] = field(default_factory=dict)
    opening: Iterator[None] | None = None
    oldest_arrival: float | None = None
    ended: set[str] = field(default_factory=set)
    _taken: asyncio.Event = field(default_factory=asyncio.Event)

    @property
    def has_actions(self) -> bool:
        """Whether actions wait, and there is room for their events: a client that does not read gets no answers."""
        return bool(self.inbox) and len(self.outbox) < MAX_OUTBOX

    @property
    def batch_size(self) -> int:
        """Actions applied together if they are there: half of the open episodes, as the agent has the other half."""
        return min(MAX_BATCH, -(-len(self.sessions) // 2))

    @property
    def max_latest_per_delivery(self) -> int:
        """Observations delivered together: half of the open episodes, unless these are few."""
        return max(self.batch_size, MAX_BATCH // 2)

    @property
    def is_ready(self) -> bool:
        """Whether the actions that wait are applied now: a portion of them has arrived, or their time is up.

        Otherwise messages would only ever become smaller, and each costs a commit, a read and a write of its own.
        """
        if not self.has_actions:
            return False
        return sum(len(batch.acts) for batch in self.inbox) >= self.batch_size or time.monotonic() >= self.due

    @property
    def is_congested(self) -> bool:
        """Whether so much waits for the client to read it that nothing more is drawn."""
        return self.transport.backlog >= MAX_BACKLOG

    @property
    def can_open(self) -> bool:
        """Whether an episode waits to be opened, and there is room for its events."""
        return bool(self.assigned) and len(self.outbox) < MAX_OUTBOX

    @property
    def has_run_end(self) -> bool:
        """Whether the end of its run is among the events to deliver."""
        return any(isinstance(event, RunEnded) for event in self.outbox)

    @property
    def free_slots(self) -> int:
        """How many more episodes it can take."""
        return self.max_episodes - len(self.sessions) - len(self.assigned)

    def claim(self, session: EpisodeSession) -> Claim:
        """Return the claim under which a session is open here."""
        return Claim(session.episode.episode_id, OPEN, self.player, session.fence)

    def claim_of(self, episode_id: str) -> Claim:
        """Return the claim of an open episode; for any other id, a claim that nobody holds (fence -1)."""
        session = self.sessions.get(episode_id)
        return Claim(episode_id, OPEN, self.player, session.fence if session else -1)

    def drop(self, episode_id: str) -> None:
        """Forget an episode, open or assigned."""
        self.sessions.pop(episode_id, None)
        if self.assigned.pop(episode_id, None) is not None:
            self.opening = None  # Only the first of them is ever begun.
        if self.clock is not None:
            self.clock.close(episode_id)

    def end(self, event: RunEnded) -> None:
        """Forget all episodes and actions, and queue the end of the run."""
        self.sessions.clear()
        self.assigned.clear()
        self.opening = None
        self.inbox.clear()
        self.clock = None
        self.outbox.append(event)

    def ask(self, batch: ActionBatch) -> None:
        """Queue a message of actions."""
        if not self.inbox:
            self.due = time.monotonic() + GATHER_SECONDS
        self.inbox.append(batch)

    def take(self) -> ActionBatch:
        """Remove and return the oldest message of actions."""
        self._taken.set()
        return self.inbox.popleft()

    async def wait_for_space(self) -> None:
        """Wait until fewer than `MAX_INBOX` messages are queued: back pressure on a client that sends too fast."""
        while len(self.inbox) >= MAX_INBOX:
            self._taken.clear()
            await self._taken.wait()

    @property
    def wants_images(self) -> bool:
        """Whether the run asked for images."""
        return not IMAGES.isdisjoint(self.run.sensors)

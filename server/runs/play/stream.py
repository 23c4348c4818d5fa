"""The engine's state of one client stream: open episodes, received actions, and events to deliver."""

import asyncio
import time
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from arramon_client.world import IMAGE_SENSORS
from arramon_server.runs.play.clocks import StreamClock
from arramon_server.runs.play.events import Event, RunEnded
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.transport import Transport
from arramon_server.runs.storage.records import OPEN, Claim, Run
from arramon_server.sim.section_world import EpisodeWorld

MAX_INBOX = 16
"""Number of queued action messages at which the server stops reading from the stream."""

MAX_BATCH = 16
"""Maximum observations in one message, and maximum actions for which a stream waits before they are applied."""

GATHER_SECONDS = 0.002
"""Longest time for which an action waits to be applied with others of its stream."""

MAX_BACKLOG = 2 << 20
"""Unsent bytes at which drawing for a stream pauses: about eight raw observations."""

MAX_OUTBOX = 8192
"""Queued events at which no further actions are applied. The open episodes of a stream need far fewer."""


@dataclass(frozen=True, slots=True)
class Act:
    """An agent's answer to one observation.

    Attributes:
        step: number of the observation.
        action: action number as sent, which the engine checks; None without an action.
        forfeit: why the agent gives up the episode; None if it does not.
        note: a note to store beside the step, which the engine checks; empty without one.
    """

    episode_id: str
    step: int
    action: int | None = None
    forfeit: str | None = None
    note: str = ""


class ActionBatch(NamedTuple):
    """The actions of one message and its arrival time, in seconds of the play clock."""

    at: float
    acts: Sequence[Act]


class AssignedEpisode(NamedTuple):
    """An episode that is claimed for a stream but not open yet.

    Attributes:
        claim: the claim under which it will be open.
        with_history: whether its earlier observations are delivered, too.
    """

    claim: Claim
    with_history: bool


@dataclass(eq=False)
class Stream:
    """A stream that joined a run.

    Attributes:
        run: the run that it plays.
        player: the client's name for itself, which it keeps when it reconnects.
        max_episodes: maximum number of episodes open at the same time.
        image_size: side length of the images, in pixels.
        images: encoding and size of the images, such as "lossless-224"; empty without images.
        history: whether the agent needs every observation of an open episode, from the first one on.
        adopt: whether to take over at once the episodes that other players left open.
        transport: encodes and sends the events.
        is_interactive: whether a person waits for each answer: it is served before the streams of agents.
        pauses: whether a person asks for each further episode: until then none is assigned, and no clock runs.
        clock: clock of its episodes; None if the run has no time limits.
        inbox: received messages of actions, oldest first; `receive` adds to them.
        due: time by `time.monotonic` at which they are applied even if few have arrived.
        outbox: events to deliver; their frames are not drawn yet.
        sessions: open episodes by id.
        worlds: their worlds.
        assigned: assigned episodes that are not open yet, by id, in order.
        opening: iterator that opens the first of them step by step; None if it has not begun.
        oldest_arrival: arrival time of the oldest actions that are not fully answered; None without such actions.
        ended: ids of episodes whose end was reported to the client: late answers to them are ignored.
        is_between: whether it pauses after an episode: the person has not asked for the next one.
    """

    run: Run
    player: str
    max_episodes: int
    image_size: int
    images: str
    history: bool
    adopt: bool
    transport: Transport
    is_interactive: bool = False
    pauses: bool = False
    clock: StreamClock | None = None
    inbox: deque[ActionBatch] = field(default_factory=deque)
    due: float = 0.0
    outbox: deque[Event] = field(default_factory=deque)
    sessions: dict[str, EpisodeSession] = field(default_factory=dict)
    worlds: dict[str, EpisodeWorld] = field(default_factory=dict)
    assigned: dict[str, AssignedEpisode] = field(default_factory=dict)
    opening: Iterator[None] | None = None
    oldest_arrival: float | None = None
    ended: set[str] = field(default_factory=set)
    is_between: bool = False
    _taken: asyncio.Event = field(default_factory=asyncio.Event)

    @property
    def has_actions(self) -> bool:
        """Whether actions wait and the outbox has space: a client that does not read gets no answers."""
        return bool(self.inbox) and len(self.outbox) < MAX_OUTBOX

    @property
    def batch_size(self) -> int:
        """Number of actions to apply in one batch: half of the open episodes, while the agent answers the others."""
        return min(MAX_BATCH, -(-len(self.sessions) // 2))

    @property
    def max_latest_per_delivery(self) -> int:
        """Maximum number of latest observations in one delivery: half of the open episodes, unless these are few."""
        return max(self.batch_size, MAX_BATCH // 2)

    @property
    def is_ready(self) -> bool:
        """Whether to apply the waiting actions now: a full batch of them has arrived, or they have waited long enough.

        Without this wait messages would become ever smaller, and each costs its own commit, read and write.
        """
        if not self.has_actions:
            return False
        return sum(len(batch.acts) for batch in self.inbox) >= self.batch_size or time.monotonic() >= self.due

    @property
    def is_congested(self) -> bool:
        """Whether so many bytes wait to be sent to the client that drawing pauses."""
        return self.transport.backlog >= MAX_BACKLOG

    @property
    def can_open(self) -> bool:
        """Whether an episode waits to be opened and the outbox has space for its events."""
        return bool(self.assigned) and len(self.outbox) < MAX_OUTBOX

    @property
    def has_run_end(self) -> bool:
        """Whether the end of its run is in the outbox."""
        return any(isinstance(event, RunEnded) for event in self.outbox)

    @property
    def free_slots(self) -> int:
        """Number of further episodes that can be assigned to it."""
        if self.is_between:
            return 0
        return self.max_episodes - len(self.sessions) - len(self.assigned)

    def claim(self, session: EpisodeSession) -> Claim:
        """Return the claim under which an episode is open on this stream."""
        return Claim(session.episode.episode_id, OPEN, self.player, session.fence)

    def claim_of(self, episode_id: str) -> Claim:
        """Return the claim of an open episode; for any other id, an invalid claim (fence -1)."""
        session = self.sessions.get(episode_id)
        return Claim(episode_id, OPEN, self.player, session.fence if session else -1)

    def note_end(self, episode_id: str) -> None:
        """Note that the end of an episode is reported: one that pauses gets no further episode until it is resumed."""
        self.ended.add(episode_id)
        self.is_between = self.pauses

    def drop(self, episode_id: str) -> None:
        """Forget an episode, open or assigned."""
        self.sessions.pop(episode_id, None)
        self.worlds.pop(episode_id, None)
        if self.assigned.pop(episode_id, None) is not None:
            self.opening = None  # Only the first one can have begun.
        if self.clock is not None:
            self.clock.close(episode_id)

    def end(self, event: RunEnded) -> None:
        """Forget all episodes and actions, and put the end of the run into the outbox."""
        self.sessions.clear()
        self.worlds.clear()
        self.assigned.clear()
        self.opening = None
        self.inbox.clear()
        self.clock = None
        self.outbox.append(event)

    def receive(self, batch: ActionBatch) -> None:
        """Put a message of actions into the inbox."""
        if not self.inbox:
            self.due = time.monotonic() + GATHER_SECONDS
        self.inbox.append(batch)

    def next_actions(self) -> ActionBatch:
        """Remove and return the oldest message of actions in the inbox."""
        self._taken.set()
        return self.inbox.popleft()

    async def wait_for_space(self) -> None:
        """Wait until the inbox holds fewer than `MAX_INBOX` messages: back pressure on a client that sends too fast."""
        while len(self.inbox) >= MAX_INBOX:
            self._taken.clear()
            await self._taken.wait()

    @property
    def wants_images(self) -> bool:
        """Whether the run's sensors include images."""
        return not set(IMAGE_SENSORS).isdisjoint(self.run.sensors)

"""Engines in the test's process, with a movable clock and streams without a network."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

import pytest

from arramon_server.episodes.splits import Split
from arramon_server.errors import ArraMonError
from arramon_server.runs.play import engine as engines
from arramon_server.runs.play import upkeep
from arramon_server.runs.play.clocks import ClockSettings
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.play.events import Encoding, EpisodeEnded, Event, Observed, RunEnded
from arramon_server.runs.play.stream import MAX_BACKLOG, Act, Stream
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import RUNNING, Run
from arramon_server.runs.storage.run_activity import RunActivity
from arramon_server.sim.cameras import Frame
from tests import tiny

CLOCKS = ClockSettings(60.0, 100.0)


class Backend:
    """A journal, a split, and any number of engines.

    Attributes:
        now: the time of the clocks; it stands still.
        wall: the time of the database, in seconds since 1970; it stands still, too.
    """

    def __init__(self, folder: Path, episodes: int = 3, *, hidden: bool = False, url: str = "") -> None:
        self.split: Split = tiny.write(folder, count=episodes, hidden=hidden)
        self.wall = datetime.now(UTC).timestamp()
        self.url = url or f"sqlite:///{folder / 'journal.db'}"
        self.database = Database(self.url, clock=lambda: self.wall)
        self.journal = Journal(self.database)
        self.activity = RunActivity(self.database)
        self.now = 1000.0

    def run(self, clocks: ClockSettings = CLOCKS, sensors: Sequence[str] = ()) -> Run:
        """Create a run of all episodes."""
        run = Run(
            run_id="run",
            participant="p",
            agent="a",
            split="tiny",
            language="en",
            sensors=tuple(sensors),
            steps_per_phase=150,
            data_hash=self.split.data_hash,
            server_version="0",
            state=RUNNING,
            created_at=datetime.fromtimestamp(self.wall, UTC),
            step_seconds=clocks.step_seconds,
            bank_seconds=clocks.bank_seconds,
            bank_left=clocks.bank_seconds if clocks else None,
        )
        self.journal.create(run, list(self.split.episodes))
        return run

    @asynccontextmanager
    async def engine(self, *, database: Database | None = None, grace: float = 0.0) -> AsyncIterator[Engine]:
        """Yield a running engine, on a database of its own or the common one; fail if it raises an error."""
        engine = Engine(
            {"tiny": self.split},
            Journal(database) if database else self.journal,
            RunActivity(database) if database else self.activity,
            grace=grace,
            now=lambda: self.now,
            monotonic=lambda: self.now,
        )
        engine.start()
        playing = asyncio.create_task(engine.run())
        try:
            yield engine
        finally:
            assert not playing.done()
            playing.cancel()
            with suppress(asyncio.CancelledError):
                await playing
            engine.stop()

    def live(self, seconds: float) -> None:
        """Let time pass, with processes that run all the while."""
        self.now += seconds
        with self.database.write() as connection:
            clock = tables.service_clock
            connection.execute(clock.update().values(seconds=clock.c.seconds + seconds))

    def causes(self) -> dict[str, int]:
        """Return the causes of the run's ended episodes."""
        return self.journal.progress("run").causes


class FakeStream:
    """A stream that has joined an engine, seen from the client, and its transport.

    Attributes:
        events: received events.
        closed: errors, or None, with which it was closed.
        reads: whether sent events leave the server at once; otherwise one delivery fills the backlog.
    """

    def __init__(
        self,
        engine: Engine,
        run: Run,
        episodes: int = 1,
        player: str = "p",
        *,
        reads: bool = True,
        history: bool = False,
        adopt: bool = True,
    ) -> None:
        self.events: list[Event] = []
        self.closed: list[ArraMonError | None] = []
        self.reads = reads
        self._engine = engine
        self._taken = 0
        self.stream = Stream(
            run=run,
            player=player,
            max_episodes=episodes,
            image_size=128,
            images="",
            history=history,
            adopt=adopt,
            transport=self,
        )
        engine.join(self.stream)

    @property
    def compresses(self) -> bool:
        return True

    @property
    def backlog(self) -> int:
        return 0 if self.reads or not self.events else MAX_BACKLOG

    def canvas(self, episode_id: str) -> Frame | None:
        return None

    def begin_encoding(self, event: Observed) -> Encoding:
        return lambda: [event.frame]

    def send(self, events: Sequence[Event]) -> None:
        self.events.extend(events)

    def close(self, error: ArraMonError | None) -> None:
        self.closed.append(error)

    async def next(self, kind: type[Event]) -> Event:
        """Return the next event of a kind, and drop those before it."""
        while True:
            while self._taken < len(self.events):
                self._taken += 1
                if isinstance(self.events[self._taken - 1], kind):
                    return self.events[self._taken - 1]
            self._engine.wake()
            await asyncio.sleep(0.001)

    async def observation(self) -> Observed:
        """Return the next observation."""
        event = await self.next(Observed)
        assert isinstance(event, Observed)
        return event

    async def ended(self) -> EpisodeEnded:
        """Return the next end of an episode."""
        event = await self.next(EpisodeEnded)
        assert isinstance(event, EpisodeEnded)
        return event

    def act(self, episode_id: str, step: int, action: int) -> None:
        self._engine.receive(self.stream, [Act(episode_id, step, action)])

    async def play(self) -> None:
        """Play the ground truth of one episode after the other until the run ends."""
        while not any(isinstance(event, RunEnded) for event in self.events):
            event = await self.next(Event)  # type: ignore[arg-type]
            if isinstance(event, Observed) and event.taken is None:
                step = event.state.step
                self.act(event.episode.episode_id, step, tiny.ACTIONS[step])


async def wait_for_rounds(engine: Engine, times: int = 5) -> None:
    """Wait for a number of the engine's rounds: by then it has done what it does by itself."""
    for _ in range(times):
        before = engine.last_round_at
        await until(lambda: engine.last_round_at > before)  # noqa: B023 - awaited at once


async def until(condition: Callable[[], bool]) -> None:
    """Wait for a condition that the engine fulfils by itself; the time limit of the test ends a wait in vain."""
    while not condition():
        await asyncio.sleep(0.002)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Set the intervals of the engine's periodic work to almost zero, so that no test waits for it."""
    monkeypatch.setattr(engines, "SWEEP_SECONDS", 0.002)
    monkeypatch.setattr(upkeep, "ACTIVE_SECONDS", 0.002)

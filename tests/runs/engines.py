"""An engine in this very process, on a time that a test moves, with streams that have no network."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

import pytest

from server.episodes.splits import Split
from server.errors import ArraMonError
from server.runs import engine as engines
from server.runs.clocks import Clocks
from server.runs.database import Database
from server.runs.engine import Engine
from server.runs.events import EpisodeEnded, Event, Observed, RunEnded
from server.runs.journal import Journal
from server.runs.ledger import Ledger
from server.runs.records import RUNNING, Run
from server.runs.stream import Act, Stream
from tests import tiny

CLOCKS = Clocks(60.0, 600.0, 100.0)


class House:
    """A journal, a split, and as many engines as a test starts.

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
        self.ledger = Ledger(self.database)
        self.now = 1000.0

    def run(self, clocks: Clocks = CLOCKS, sensors: Sequence[str] = ()) -> Run:
        """A new run of all episodes."""
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
            first_step_seconds=clocks.first_step_seconds,
            bank_seconds=clocks.bank_seconds,
            bank_left=clocks.bank_seconds if clocks else None,
        )
        self.journal.create(run, list(self.split.episodes))
        return run

    @asynccontextmanager
    async def engine(self, *, idle_seconds: float = 0.0, database: Database | None = None) -> AsyncIterator[Engine]:
        """An engine that plays while the block lasts, on a database of its own or the common one; it must not break."""
        engine = Engine(
            {"tiny": self.split},
            Journal(database) if database else self.journal,
            Ledger(database) if database else self.ledger,
            grace=0.0,
            idle_seconds=idle_seconds,
            now=lambda: self.now,
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

    def causes(self) -> dict[str, int]:
        """Of the run's ended episodes."""
        return self.journal.progress("run").causes


class Seat:
    """A stream's place at an engine.

    Attributes:
        events: that it was told.
        closed: with what it was closed, if it was.
        reads: whether what it is told leaves the server at once.
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
            adopt=True,
            deliver=self._deliver,
            close=self.closed.append,
            backlog=lambda: 0,
        )
        engine.join(self.stream)

    def _deliver(self, events: Sequence[Event]) -> None:
        self.events.extend(events)
        if self.reads:
            asyncio.get_running_loop().call_soon(self._engine.has_left, self.stream)

    async def next(self, kind: type[Event]) -> Event:
        """The next event of a kind; others before it are passed over."""
        while True:
            while self._taken < len(self.events):
                self._taken += 1
                if isinstance(self.events[self._taken - 1], kind):
                    await asyncio.sleep(0)  # so that it has left
                    return self.events[self._taken - 1]
            self._engine.wake()
            await asyncio.sleep(0.001)

    async def observation(self) -> Observed:
        """The next observation."""
        event = await self.next(Observed)
        assert isinstance(event, Observed)
        return event

    async def ended(self) -> EpisodeEnded:
        """The next end of an episode."""
        event = await self.next(EpisodeEnded)
        assert isinstance(event, EpisodeEnded)
        return event

    def act(self, episode_id: str, step: int, action: int) -> None:
        self._engine.ask(self.stream, [Act(episode_id, step, action)])

    async def play(self) -> None:
        """Plays the ground truth of one episode after the other, until the run ends."""
        while not any(isinstance(event, RunEnded) for event in self.events):
            event = await self.next(Event)  # type: ignore[arg-type]
            if isinstance(event, Observed) and event.taken is None:
                step = event.state.step
                self.act(event.episode.episode_id, step, tiny.ACTIONS[step])


async def until(condition: Callable[[], bool]) -> None:
    """Waits for what the engine does by itself; a test that waits in vain is ended from outside."""
    while not condition():
        await asyncio.sleep(0.002)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """The engine looks at what nobody asked for all the time, so that no test waits for it."""
    monkeypatch.setattr(engines, "SWEEP_SECONDS", 0.002)
    monkeypatch.setattr(engines, "ACTIVE_SECONDS", 0.002)

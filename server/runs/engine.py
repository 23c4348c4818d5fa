"""The engine: plays all episodes of this process. It owns the worlds and the open episodes.

Each round it takes one message from every stream that sent one, applies it, commits all of it at once, and only then
tells anyone; then it draws and delivers for every stream in turn, a few milliseconds each, so that none starves others.
It runs on the event loop that also carries the streams: between two turns the loop moves bytes.
"""

import asyncio
import logging
import time
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager

from server.episodes.splits import Split
from server.errors import ArraMonError, Conflict, TakenOver, Unavailable
from server.runs.absence import Absences
from server.runs.answering import Answering
from server.runs.clocks import Stopwatch
from server.runs.closing import Closing
from server.runs.delivering import Delivering, can_be_told
from server.runs.departures import Departures
from server.runs.events import EpisodeEnded, RunEnded
from server.runs.faults import Faults
from server.runs.journal import Journal
from server.runs.ledger import Ledger
from server.runs.meter import NO_METER, Meter, Stage
from server.runs.offering import Offering
from server.runs.opening import Opening
from server.runs.records import CANCELLED, COMPLETE, RUNNING, Batch, Claim, Run
from server.runs.stream import Act, Asked, Stream
from server.runs.timekeeping import Timekeeper
from server.runs.worlds import Worlds
from server.sim.cameras import CAMERAS

GRACE = 10.0
"""Seconds for which an episode that a broken stream left open waits for its own player."""

SWEEP_SECONDS = 1.0
"""Between two looks at what nobody asked for: signs of life, and episodes whose players did not come back."""

OPENING_SECONDS = 0.004
"""In a round, for opening episodes: to play again what was played of a thousand takes many times that."""

ACTIVE_SECONDS = 60.0
"""Between two notes that a run is being played, and two looks for a run that lies idle."""

_log = logging.getLogger(__name__)


class Engine:
    """Plays episodes. Everything is to be called on one event loop.

    Args:
        splits: by name.
        journal: everything goes there before anyone is told.
        ledger: keeps banks and counts.
        camera: what draws, one of `cameras.CAMERAS`.
        address: of this process alone; empty where it has none.
        grace: seconds for which an orphaned episode waits for its player.
        idle_seconds: for which a run may lie idle before it is closed with what it has; 0 for ever.
        now: the clocks' time, in seconds.
        meter: is told what is measured.
    """

    def __init__(
        self,
        splits: Mapping[str, Split],
        journal: Journal,
        ledger: Ledger,
        *,
        camera: str = CAMERAS[0],
        address: str = "",
        grace: float = GRACE,
        idle_seconds: float = 0.0,
        now: Callable[[], float] | None = None,
        meter: Meter = NO_METER,
    ) -> None:
        self._meter = meter
        self._journal = journal
        self._ledger = ledger
        self._idle_seconds = idle_seconds
        self._data = [split.data_hash for split in splits.values()]
        self._address = address
        self._worlds = Worlds(splits, camera)
        self._work = asyncio.Event()
        self._worker = uuid.uuid4().hex
        opening = Opening(splits, journal, self._worlds)
        self._faults = Faults(journal, ledger, opening)
        self._offering = Offering(journal, opening, self._faults, self._worker, grace)
        self._closing = Closing(journal, opening, self._worker)
        self._time = Timekeeper(ledger, now or Stopwatch())
        self._absences = Absences(journal, ledger, self._time.now)
        self._answering = Answering(journal, self._time)
        self._delivering = Delivering(self._worlds, self._take, self._drop, meter)
        self._cancelling: set[str] = set()
        self._streams: list[Stream] = []
        self._departures = Departures(journal)
        self._next_sweep = self._next_note = 0.0
        self._stopped = False
        self.turned_at = time.monotonic()
        """When it last looked at anything; each second, when it is idle."""

    @property
    def worker(self) -> str:
        """This process, as the journal knows it."""
        return self._worker

    def join(self, stream: Stream) -> None:
        """A stream comes in."""
        if self._stopped:
            stream.close(Unavailable("this process of the server is about to end; try again, and another answers"))
            return
        for other in list(self._streams):
            if (other.run.run_id, other.player) == (stream.run.run_id, stream.player):
                self._drop(other, Conflict("another stream of the same player took this one's place"))
        self._streams.append(stream)
        _log.info("stream opened", extra={"run_id": stream.run.run_id, "episodes": stream.max_episodes})
        with self._guard(stream):
            self._time.start(stream, self._streams)
            self._ledger.note_active([stream.run.run_id])
            if stream.images:
                self._journal.note_images(stream.run.run_id, stream.images)
            self._offering.offer(stream, self._held(stream.run), first=True)
            if not stream.coming:
                self._after_ending(stream)
        self.wake()

    def ask(self, stream: Stream, acts: Iterable[Act]) -> None:
        """A stream answers observations."""
        stream.asked.append(Asked(self._time.now(), tuple(acts)))
        self.wake()

    def leave(self, stream: Stream) -> None:
        """A stream is gone; its episodes stay open, for its player first and after a while for others."""
        if stream in self._streams:
            self._streams.remove(stream)
            _log.info("stream left", extra={"run_id": stream.run.run_id, "episodes": len(stream.sessions)})
            epochs = self._departures.add(stream, self._time.now())
            if stream.clock is not None:
                self._absences.begin(stream.run.run_id, epochs)
            with self._guard():
                self._departures.write()

    def has_left(self, stream: Stream) -> None:
        """What a stream was delivered first of what has not left yet, has left the server: its clocks run."""
        if stream.clock is not None:
            stream.clock.leave()
        self.wake()

    def wake(self) -> None:
        """There is something to do: a message came in, or a stream that was slow can take more."""
        self._work.set()

    def start(self) -> None:
        """Makes this process known.

        Raises:
            StorageError: if the journal cannot be written.
        """
        if self._idle_seconds:
            self._ledger.excuse_idle(self._idle_seconds)
        self._journal.beat(self._worker, self._address)

    async def run(self) -> None:
        """Plays until it is cancelled."""
        while True:
            self._work.clear()  # before anything is looked at: who calls while this works is not to be missed
            self._sweep()
            self._apply()
            self._open()
            for stream in list(self._streams):
                over = self._delivering.turn(stream)
                if stream.since is not None and not stream.told:
                    self._meter.took(Stage.TOTAL, self._time.now() - stream.since)
                    stream.since = None
                if over and stream in self._streams:
                    self._streams.remove(stream)
                    stream.close(None)
                await asyncio.sleep(0)
            if not self._is_busy():
                await self._work.wait()

    def stop(self) -> None:
        """Ends all streams in good order, frees their episodes for other processes, and lets the worlds go."""
        self._stopped = True
        for stream in list(self._streams):
            self._drop(stream, None)
        with self._guard():
            self._journal.retire(self._worker)
        self._worlds.close()

    async def cancel(self, run: Run) -> None:
        """Forfeits what is left of a run, in portions, between which others are served.

        Raises:
            Conflict: if the run is over already, or is just being cancelled.
        """
        run = self._journal.run(run.run_id)
        if run.state != RUNNING or run.run_id in self._cancelling:
            state = run.state if run.state != RUNNING else CANCELLED
            raise Conflict(f"run {run.run_id!r} is {state.lower()} already")
        self._cancelling.add(run.run_id)
        try:
            while self._closing.forfeit_some(run, "the run was cancelled"):
                await asyncio.sleep(0)
            if self._journal.run(run.run_id).state == RUNNING:  # or another process has seen its end first
                self._finish(run, CANCELLED)
        finally:
            self._cancelling.discard(run.run_id)
        self.wake()

    def _is_busy(self) -> bool:
        return any(stream.is_asking or stream.can_open or can_be_told(stream) for stream in self._streams)

    def _sweep(self) -> None:
        """Now and then: says that this worker lives, and looks for what its idle streams could do."""
        self.turned_at = time.monotonic()
        if self.turned_at < self._next_sweep:
            return
        self._next_sweep = time.monotonic() + SWEEP_SECONDS
        asyncio.get_running_loop().call_later(1.01 * SWEEP_SECONDS, self.wake)
        with self._guard():
            self._journal.beat(self._worker, self._address)
            self._departures.write()
            self._absences.count()
            self._look_for_idle()
        waiting = sum(len(stream.asked) for stream in self._streams)
        self._meter.loaded(len(self._streams), sum(len(stream.sessions) for stream in self._streams), waiting)
        now = self._time.now()
        for stream in list(self._streams):
            if stream.clock is not None and not stream.is_asking:
                with self._guard(stream):
                    self._check(stream, now)
            if stream in self._streams and stream.room:
                with self._guard(stream):
                    self._after_ending(stream)

    def _look_for_idle(self) -> None:
        """Notes which runs are being played, and closes some of one that nobody has played for too long."""
        if not self._idle_seconds or time.monotonic() < self._next_note:
            return
        self._next_note = time.monotonic() + min(ACTIVE_SECONDS, self._idle_seconds / 4)
        self._ledger.note_active({stream.run.run_id for stream in self._streams})
        run = self._ledger.idle(self._idle_seconds, self._data)
        if run is None:
            return
        self._next_note = 0.0  # there may be more to close
        if not self._closing.forfeit_some(run, f"nobody had played the run for {self._idle_seconds:.0f} seconds"):
            self._finish(run, COMPLETE)

    def _check(self, stream: Stream, now: float) -> None:
        """Holds a stream that says nothing to its clocks."""
        batch = Batch()
        events = self._answering.timed(stream, now, batch)
        self._journal.commit(batch)
        stream.told.extend(events)
        if batch.charges:
            self._time.refresh(stream)
        self._take_faulty()

    def _apply(self) -> None:
        asking = [stream for stream in self._streams if stream.is_asking]
        batch, now = Batch(), self._time.now()
        holders = {(stream.run.run_id, episode_id): stream for stream in asking for episode_id in stream.sessions}
        for stream in asking:
            stream.since = stream.asked[0].at
            self._meter.took(Stage.QUEUE, now - stream.since)
        with self._guard(*asking):
            told = [(stream, self._answering.answers(stream, batch)) for stream in asking]
            if asking:
                self._meter.took(Stage.RULES, self._time.now() - now)
            losers = self._commit(batch, holders)
            for stream in asking if batch.charges else ():  # other processes have charged the same bank
                self._time.refresh(stream)
            for stream, answers in told:
                if stream not in losers:
                    stream.told.extend(answers)
        self._take_faulty()
        for stream in asking:
            if stream in self._streams and any(isinstance(event, EpisodeEnded) for event in stream.told):
                with self._guard(stream):
                    self._after_ending(stream)

    def _open(self) -> None:
        """Goes on opening what comes to streams, for a moment; who had it stands behind the others next time."""
        until = time.perf_counter() + OPENING_SECONDS
        for stream in [stream for stream in self._streams if stream.can_open]:
            if time.perf_counter() >= until:
                return
            self._streams.remove(stream)
            self._streams.append(stream)
            with self._guard(stream):
                self._offering.open(stream, until)

    def _commit(self, batch: Batch, holders: Mapping[tuple[str, str], Stream]) -> set[Stream]:
        """Commits what streams did. One that lost an episode to another process is dropped alone, and returned."""
        try:
            self._journal.commit(batch)
            return set()
        except TakenOver as error:
            losers = {holders[key] for key in self._journal.lost(batch)}
            if not losers:
                raise
            _log.warning("%s", error)
            self._meter.faulted(type(error).__name__)
            for stream in losers:
                self._drop(stream, error)
        self._journal.commit(batch.without({key for key, stream in holders.items() if stream in losers}))
        return losers

    @contextmanager
    def _guard(self, *streams: Stream) -> Iterator[None]:
        """Drops the streams where the journal fails, as memory may then be ahead of it. Their clients come back."""
        try:
            yield
        except ArraMonError as error:
            runs = sorted({stream.run.run_id for stream in streams})
            _log.error("%s", error, extra={"fault": type(error).__name__, "runs": runs})
            self._meter.faulted(type(error).__name__)
            for stream in streams:
                self._drop(stream, error)

    def _take_faulty(self) -> None:
        """Takes from their streams the episodes over which the server broke down, once all else is committed."""
        faulty, self._answering.faulty = self._answering.faulty, []
        for stream, claim in faulty:
            self._take(stream, claim)

    def _take(self, stream: Stream, claim: Claim) -> None:
        self._meter.faulted("EpisodeFault")
        if stream in self._streams:
            with self._guard(stream):
                self._faults.take(stream, claim)

    def _after_ending(self, stream: Stream) -> None:
        """Ends the run where nothing is left of it; otherwise gives the stream its next episodes."""
        run = self._journal.run(stream.run.run_id)
        if run.state != RUNNING:
            stream.told.append(RunEnded(run, self._journal.progress(run.run_id)))
        elif run.run_id in self._cancelling:
            pass  # it is told with all others that the run is over
        elif not self._journal.count_unended(run.run_id):
            self._finish(run, COMPLETE)
        else:
            self._offering.offer(stream, self._held(run))

    def _held(self, run: Run) -> set[str]:
        return {
            episode
            for other in self._streams
            if other.run.run_id == run.run_id
            for episode in (*other.sessions, *other.coming)
        }

    def _finish(self, run: Run, state: str) -> None:
        self._journal.set_state(run.run_id, state)
        over = RunEnded(self._journal.run(run.run_id), self._journal.progress(run.run_id))
        for stream in self._streams:
            if stream.run.run_id == run.run_id:
                stream.sessions.clear()
                stream.coming.clear()
                stream.opening = None
                stream.asked.clear()
                stream.clock = None
                stream.told.append(over)

    def _drop(self, stream: Stream, error: ArraMonError | None) -> None:
        self.leave(stream)
        stream.close(error)

"""The engine, which plays all episodes of one server process. It owns the worlds and the open episodes.

Each round of its loop (`Engine.run`) applies the actions of every stream, writes them to the journal in one commit, and
only then delivers the resulting events. Drawing and delivery take a few milliseconds per stream in turn, so that no
stream starves another. The loop shares the event loop with gRPC, which moves bytes in between.
"""

import asyncio
import logging
import time
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager

from arramon_server.episodes.splits import Split
from arramon_server.errors import ArraMonError, Conflict, Replaced, TakenOver
from arramon_server.image_threads import ImageThreads
from arramon_server.runs.play.actions import ActionHandler, ActionResults
from arramon_server.runs.play.assignment import GRACE, Assignment
from arramon_server.runs.play.clocks import PlayClock
from arramon_server.runs.play.delivery import Delivery, is_deliverable
from arramon_server.runs.play.events import EpisodeEnded, RunEnded
from arramon_server.runs.play.faults import FaultHandler
from arramon_server.runs.play.forfeits import Forfeits
from arramon_server.runs.play.note_limits import DEFAULT_NOTE_LIMITS, NoteLimits
from arramon_server.runs.play.notes import NoteTaker
from arramon_server.runs.play.session_loader import SessionLoader
from arramon_server.runs.play.stream import GATHER_SECONDS, Act, ActionBatch, Stream
from arramon_server.runs.play.timekeeper import Timekeeper
from arramon_server.runs.play.upkeep import SWEEP_SECONDS, Upkeep
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.meter import NO_METER, Meter, Stage
from arramon_server.runs.storage.records import CANCELLED, CLOSER, COMPLETE, RUNNING, Claim, CommitBatch, Run
from arramon_server.runs.storage.run_activity import RunActivity
from arramon_server.runs.storage.run_duration import RunDurations
from arramon_server.sim.cameras import CAMERAS

OPENING_SECONDS = 0.004
"""Time limit per round for opening episodes: replaying a thousand interrupted ones takes many times as long."""

_log = logging.getLogger(__name__)


class Engine:
    """Plays episodes. Call all methods on one event loop, unless stated otherwise.

    Args:
        splits: splits by name.
        journal: storage of all steps; events are delivered only after they are written to it.
        activity: banks, last play and fault counts of runs.
        camera: one of `cameras.CAMERAS`.
        threads: threads in which frames are drawn; None for new ones.
        address: address of this process alone; empty if it has none.
        grace: seconds for which an orphaned episode is reserved for the same player.
        now: clock of play, in seconds.
        monotonic: monotonic clock, in seconds.
        meter: receives the measurements.
        note_limits: limits of the notes that agents leave beside their steps.
    """

    def __init__(
        self,
        splits: Mapping[str, Split],
        journal: Journal,
        activity: RunActivity,
        *,
        camera: str = CAMERAS[0],
        threads: ImageThreads | None = None,
        address: str = "",
        grace: float = GRACE,
        now: Callable[[], float] | None = None,
        monotonic: Callable[[], float] = time.monotonic,
        meter: Meter = NO_METER,
        note_limits: NoteLimits = DEFAULT_NOTE_LIMITS,
    ) -> None:
        self._meter = meter
        self._journal = journal
        self._activity = activity
        self._worlds = Worlds(splits, camera)
        self._work = asyncio.Event()
        self._worker = uuid.uuid4().hex
        loader = SessionLoader(splits, journal, self._worlds)
        self._faults = FaultHandler(journal, activity, loader)
        self._assignment = Assignment(journal, loader, self._faults, self._worker, grace)
        self._forfeits = Forfeits(journal, loader, self._worker)
        self._time = Timekeeper(activity, now or PlayClock())
        self._durations = RunDurations(monotonic)
        self._actions = ActionHandler(journal, self._time, NoteTaker(journal, note_limits, monotonic))
        drawing = (threads or ImageThreads()) if self._worlds.draws_in_threads else ImageThreads(cores=1)
        self._delivery = Delivery(drawing, self._time.now, meter)
        self._upkeep = Upkeep(
            journal,
            activity,
            [split.data_hash for split in splits.values()],
            worker=self._worker,
            address=address,
        )
        self._cancelling: set[str] = set()
        self._streams: list[Stream] = []
        self._next_sweep = 0.0
        self._stopped = False
        self.last_round_at = time.monotonic()
        """Time of the latest round, at most about a second ago if the engine is alive."""

    @property
    def worker(self) -> str:
        """The id of this process in the journal."""
        return self._worker

    def note_new_run(self, run: Run) -> None:
        """Note that this process has just created a run. Thread-safe."""
        self._durations.begin(run, run.created_at)

    def join(self, stream: Stream) -> None:
        """Add a stream, and assign episodes to it; one that opens while the process drains ends like the others."""
        if self._stopped:
            stream.transport.close(None)
            return
        for other in list(self._streams):
            if (other.run.run_id, other.player) == (stream.run.run_id, stream.player):
                self._drop(other, Replaced("replaced by a newer stream of the same player"))
        self._streams.append(stream)
        _log.info("stream opened", extra={"run_id": stream.run.run_id, "episodes": stream.max_episodes})
        with self._guard(stream):
            if stream.run.state == RUNNING and not self._durations.knows(stream.run.run_id):
                self._durations.begin(stream.run, self._journal.time())
            self._activity.note_active([stream.run.run_id])
            if stream.images:
                self._journal.record_image_format(stream.run.run_id, stream.images)
            self._assignment.assign(stream, self._held(stream.run), first=True)
            self._time.start(stream, self._streams)
            if not stream.assigned:
                self._after_ending(stream)
        self.wake()

    def receive(self, stream: Stream, acts: Iterable[Act]) -> None:
        """Queue the actions of one message."""
        stream.receive(ActionBatch(self._time.now(), tuple(acts)))
        if stream.is_ready:
            self.wake()
        else:
            asyncio.get_running_loop().call_later(1.01 * GATHER_SECONDS, self.wake)

    def resume(self, stream: Stream) -> None:
        """Assign further episodes to a stream that pauses between them."""
        stream.is_between = False
        if stream in self._streams and stream.free_slots and not stream.has_run_end:
            with self._guard(stream):
                self._after_ending(stream)
        self.wake()

    def leave(self, stream: Stream) -> None:
        """Remove a closed stream. Its episodes stay open, at first for the same player, later for others, too."""
        if stream in self._streams:
            self._streams.remove(stream)
            _log.info("stream left", extra={"run_id": stream.run.run_id, "episodes": len(stream.sessions)})
            self._upkeep.releases.add(stream, self._time.now())
            with self._guard():
                self._upkeep.releases.write()

    def wake(self) -> None:
        """Start a round, because a message arrived or a congested stream can take more."""
        self._work.set()

    def start(self) -> None:
        """Register this process.

        Raises:
            StorageError: if the journal cannot be written.
        """
        self._upkeep.start()

    async def run(self) -> None:
        """Play until cancelled."""
        while True:
            self._work.clear()  # First, so that a wake during this round is not missed.
            self._sweep()
            self._apply()
            self._open()
            await self._deliver_in_turn()
            if not self._is_busy():
                await self._work.wait()

    async def _deliver_in_turn(self) -> None:
        """Give each stream its turn: people first, then agents until a person has sent something meanwhile.

        At least one agent gets its turn, and those that had theirs come last in the next round, so that none starves.
        """
        people = [stream for stream in self._streams if stream.is_interactive]
        for stream in people:
            self._deliver(stream)
            await asyncio.sleep(0)
        for stream in [stream for stream in self._streams if not stream.is_interactive]:
            had_events = is_deliverable(stream)
            self._deliver(stream)
            await asyncio.sleep(0)
            if people and had_events and stream in self._streams:
                self._streams.remove(stream)
                self._streams.append(stream)
                if any(person.is_ready for person in people):
                    return

    def stop(self) -> None:
        """Close all streams without an error, free their episodes for other processes, and close the worlds."""
        self._stopped = True
        for stream in list(self._streams):
            self._drop(stream, None)
        with self._guard():
            self._journal.retire(self._worker)
        self._worlds.close()

    async def cancel(self, run: Run) -> None:
        """Forfeit the remaining episodes of a run, in small batches between which other streams are served.

        Raises:
            Conflict: if the run is over, or is being cancelled already.
        """
        run = self._journal.run(run.run_id)
        if run.state != RUNNING or run.run_id in self._cancelling:
            state = run.state if run.state != RUNNING else CANCELLED
            raise Conflict(f"run {run.run_id!r} is already {state.lower()}")
        self._cancelling.add(run.run_id)
        try:
            while self._forfeits.cancel_some(run, "the run was cancelled", self._durations.time(run.run_id)):
                await asyncio.sleep(0)
            self._finish(run, CANCELLED)
        finally:
            self._cancelling.discard(run.run_id)
        self.wake()

    def _is_busy(self) -> bool:
        return any(stream.is_ready or stream.can_open or is_deliverable(stream) for stream in self._streams)

    def _apply(self) -> None:
        """Apply the waiting actions of all streams, commit them, and queue the resulting events."""
        ready = [stream for stream in self._streams if stream.is_ready and stream.run.run_id not in self._cancelling]
        batch, now = CommitBatch(), self._time.now()
        holders = _holders(ready)
        answers: dict[Stream, ActionResults] = {}
        for stream in ready:
            stream.oldest_arrival = stream.inbox[0].at
            self._meter.record_duration(Stage.QUEUE, now - stream.oldest_arrival)
        with self._guard(*ready):
            for stream in ready:
                answers[stream] = self._actions.handle(stream, batch)
            if ready:
                self._meter.record_duration(Stage.RULES, self._time.now() - now)
            losers = self._commit(batch, holders)
            for stream in ready if batch.charges else ():  # Other processes may have charged the same bank.
                self._time.refresh(stream)
            for stream in ready:
                if stream not in losers:
                    stream.outbox.extend(answers[stream].events)
        for stream, answer in answers.items():
            self._handle_faults(stream, answer.faulty)
        for stream in ready:
            if stream in self._streams and any(isinstance(event, EpisodeEnded) for event in stream.outbox):
                with self._guard(stream):
                    self._after_ending(stream)

    def _commit(self, batch: CommitBatch, holders: Mapping[tuple[str, str], Stream]) -> set[Stream]:
        """Commit a batch. Close and return the streams that lost an episode; their steps are not written.

        Their clients reconnect and get the new state: the episode is played elsewhere, or its run was closed.
        """
        try:
            self._journal.commit(batch)
            return set()
        except TakenOver as error:
            lost = self._journal.lost_episodes(batch)
            losers = {holders[key] for key in lost}
            if not losers:
                raise
            players = self._journal.players_of(lost)
            closed = {holders[key] for key, player in players.items() if player == CLOSER}
            moved = {holders[key] for key, player in players.items() if player == holders[key].player} - closed
            for stream in closed:
                run_id = stream.run.run_id
                _log.info("run closed while it was played", extra={"run_id": run_id})
                self._drop(stream, TakenOver(f"run {run_id!r} was closed while it was played; try again to see it"))
            for stream in moved:
                _log.info("player continues at another process", extra={"run_id": stream.run.run_id})
            if losers - closed - moved:
                _log.warning("%s", error)
                self._meter.count_fault(type(error).__name__)
            for stream in losers - closed:
                self._drop(stream, error)
        self._journal.commit(batch.without({key for key, stream in holders.items() if stream in losers}))
        return losers

    def _open(self) -> None:
        """Open assigned episodes for a few milliseconds. A stream that had its turn comes last in the next round."""
        until = time.perf_counter() + OPENING_SECONDS
        for stream in [stream for stream in self._streams if stream.can_open]:
            if time.perf_counter() >= until:
                return
            self._streams.remove(stream)
            self._streams.append(stream)
            with self._guard(stream):
                self._assignment.open(stream, until)

    def _deliver(self, stream: Stream) -> None:
        """Give a stream its turn of drawing and delivery."""
        done = self._delivery.deliver(stream)
        self._handle_faults(stream, done.faulty)
        if done.error is not None:
            self._drop(stream, done.error)
        if stream.oldest_arrival is not None and not stream.outbox:
            self._meter.record_duration(Stage.TOTAL, self._time.now() - stream.oldest_arrival)
            stream.oldest_arrival = None
        if done.run_ended and stream in self._streams:
            self._streams.remove(stream)
            stream.transport.close(None)

    def _sweep(self) -> None:
        """Once a second, do the upkeep, and check silent streams: time limits, end of the run, further episodes."""
        self.last_round_at = time.monotonic()
        if self.last_round_at < self._next_sweep:
            return
        self._next_sweep = time.monotonic() + SWEEP_SECONDS
        asyncio.get_running_loop().call_later(1.01 * SWEEP_SECONDS, self.wake)
        with self._guard():
            self._close_abandoned(self._upkeep.sweep(self._streams))
            self._check_for_ended_runs()
        waiting = sum(len(stream.inbox) for stream in self._streams)
        self._meter.record_load(len(self._streams), sum(len(stream.sessions) for stream in self._streams), waiting)
        now = self._time.now()
        for stream in list(self._streams):
            is_played = stream.run.run_id not in self._cancelling
            if stream.clock is not None and is_played and not stream.has_actions:
                with self._guard(stream):
                    self._check_clocks(stream, now)
            if stream in self._streams and stream.free_slots and not stream.has_run_end:
                with self._guard(stream):
                    self._after_ending(stream)

    def _check_clocks(self, stream: Stream, now: float) -> None:
        """Enforce the time limits of a silent stream."""
        batch, holders = CommitBatch(), _holders([stream])
        answers = self._actions.check_clocks(stream, now, batch)
        if not self._commit(batch, holders):
            stream.outbox.extend(answers.events)
        if batch.charges:
            self._time.refresh(stream)
        self._handle_faults(stream, answers.faulty)

    def _close_abandoned(self, run: Run | None) -> None:
        """Forfeit some episodes of an abandoned run, and complete the run once none is left."""
        if run is None:
            return
        if not self._forfeits.forfeit_some(run, "the client was away for longer than the run allows"):
            self._finish(run, COMPLETE)

    def _check_for_ended_runs(self) -> None:
        """Announce the end of runs that another process ended, such as a host's `runs cancel`."""
        for run in self._journal.ended_runs({stream.run.run_id for stream in self._streams if not stream.has_run_end}):
            self._announce_end(run)

    @contextmanager
    def _guard(self, *streams: Stream) -> Iterator[None]:
        """Close the streams if the journal fails, as memory may be ahead of the journal. Their clients reconnect."""
        try:
            yield
        except ArraMonError as error:
            runs = sorted({stream.run.run_id for stream in streams})
            _log.error("%s", error, extra={"fault": type(error).__name__, "runs": runs})
            self._meter.count_fault(type(error).__name__)
            for stream in streams:
                self._drop(stream, error)

    def _handle_faults(self, stream: Stream, claims: Iterable[Claim]) -> None:
        """Offer the episodes on which the server failed again, or end them; call it after the commit."""
        for claim in claims:
            self._meter.count_fault("EpisodeFault")
            if stream in self._streams:
                with self._guard(stream):
                    self._faults.handle(stream, claim)

    def _after_ending(self, stream: Stream) -> None:
        """Finish the run if all its episodes have ended; otherwise assign further episodes to the stream."""
        run = self._journal.run(stream.run.run_id)
        if run.state != RUNNING:
            stream.outbox.append(RunEnded(run, self._journal.progress(run.run_id)))
        elif run.run_id in self._cancelling:
            pass  # `cancel` announces the end to all streams.
        elif not self._journal.count_unended(run.run_id):
            self._finish(run, COMPLETE)
        else:
            self._assignment.assign(stream, self._held(run))
            if stream.assigned:
                self._time.refresh(stream)

    def _held(self, run: Run) -> set[str]:
        """Return the ids of the run's episodes that are open or assigned on streams of this process."""
        return {
            episode
            for other in self._streams
            if other.run.run_id == run.run_id
            for episode in (*other.sessions, *other.assigned)
        }

    def _finish(self, run: Run, state: str) -> None:
        self._journal.set_state(run.run_id, state, self._durations.time(run.run_id))
        self._announce_end(self._journal.run(run.run_id))

    def _announce_end(self, run: Run) -> None:
        """Announce the end of a run to its streams, and remove all its episodes from them."""
        self._durations.forget(run.run_id)
        over = RunEnded(run, self._journal.progress(run.run_id))
        for stream in self._streams:
            if stream.run.run_id == run.run_id and not stream.has_run_end:
                stream.end(over)

    def _drop(self, stream: Stream, error: ArraMonError | None) -> None:
        self.leave(stream)
        stream.transport.close(error)


def _holders(streams: Iterable[Stream]) -> dict[tuple[str, str], Stream]:
    """Return the stream of each open episode, by run and episode id."""
    return {(stream.run.run_id, episode_id): stream for stream in streams for episode_id in stream.sessions}

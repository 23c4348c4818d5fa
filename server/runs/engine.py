"""The engine: plays all episodes of this process. It owns the worlds and the open episodes.

Each round it takes one message from every stream that sent one, applies it, commits all of it at once, and only then
tells anyone; then it draws and delivers for every stream in turn, a few milliseconds each, so that none starves others.
It runs on the event loop that also carries the streams: between two turns the loop moves bytes.
"""

import asyncio
import logging
import time
import uuid
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace

from server.episodes.splits import Split
from server.errors import ArraMonError, Conflict, NotFound, Unavailable
from server.runs import causes
from server.runs.events import EpisodeEnded, EpisodeStarted, Event, Observed, Opened, PhaseOver, Problem, RunEnded
from server.runs.journal import Journal
from server.runs.records import CANCELLED, COMPLETE, OPEN, RUNNING, Batch, Claim, Ending, Run
from server.runs.session import Session
from server.runs.stream import Act, Stream
from server.runs.worlds import Worlds
from server.sim.cameras import CAMERAS
from server.sim.rules import Action, Limits

GRACE = 10.0
"""Seconds for which an episode that a broken stream left open waits for its own player."""

LEASE = 5.0
"""Seconds after its last sign of life from which on a worker counts as dead, and what it held as left."""

TURN_SECONDS, TURN_EVENTS = 0.004, 16
"""A stream's turn: so long it is drawn for, and so many events it is told at the most, before the next one's turn."""

SWEEP_SECONDS = 1.0
"""Between two looks at what nobody asked for: signs of life, and episodes whose players did not come back."""

MAX_BACKLOG = 8
"""Deliveries waiting to leave, from which on a slow reader gets nothing more drawn."""

_log = logging.getLogger(__name__)


class Engine:
    """Plays episodes. Everything is to be called on one event loop.

    Args:
        splits: by name.
        journal: everything goes there before anyone is told.
        camera: what draws, one of `cameras.CAMERAS`.
        address: of this process alone; empty where it has none.
        grace: seconds for which an orphaned episode waits for its player.
    """

    def __init__(
        self,
        splits: Mapping[str, Split],
        journal: Journal,
        *,
        camera: str = CAMERAS[0],
        address: str = "",
        grace: float = GRACE,
    ) -> None:
        self._splits = splits
        self._journal = journal
        self._address = address
        self._grace = grace
        self._worlds = Worlds(splits, camera)
        self._work = asyncio.Event()
        self._worker = uuid.uuid4().hex
        self._streams: list[Stream] = []
        self._to_release: list[tuple[str, dict[str, int], float]] = []
        self._next_sweep = 0.0

    def join(self, stream: Stream) -> None:
        """A stream comes in."""
        for other in list(self._streams):
            if (other.run.run_id, other.player) == (stream.run.run_id, stream.player):
                self._drop(other, Conflict("another stream of the same player took this one's place"))
        self._streams.append(stream)
        with self._guard(stream):
            if stream.images:
                self._journal.note_images(stream.run.run_id, stream.images)
            self._offer(stream, first=True)
            if not stream.sessions:
                self._after_ending(stream)
        self.wake()

    def ask(self, stream: Stream, acts: Iterable[Act]) -> None:
        """A stream answers observations."""
        stream.asked.append(tuple(acts))
        self.wake()

    def leave(self, stream: Stream) -> None:
        """A stream is gone; its episodes stay open, for its player first and after a while for others."""
        if stream in self._streams:
            self._streams.remove(stream)
            epochs = {episode_id: session.epoch for episode_id, session in stream.sessions.items()}
            self._to_release.append((stream.run.run_id, epochs, time.time()))
            with self._guard():
                self._release()

    def wake(self) -> None:
        """There is something to do: a message came in, or a stream that was slow can take more."""
        self._work.set()

    def start(self) -> None:
        """Makes this process known.

        Raises:
            StorageError: if the journal cannot be written.
        """
        self._journal.beat(self._worker, time.time(), self._address)

    async def run(self) -> None:
        """Plays until it is cancelled."""
        while True:
            self._sweep()
            self._apply()
            for stream in list(self._streams):
                self._tell(stream)
                await asyncio.sleep(0)
            if not self._is_busy():
                self._work.clear()
                await self._work.wait()

    def stop(self) -> None:
        """Closes all streams and lets the worlds go."""
        for stream in list(self._streams):
            self._drop(stream, Unavailable("the server is shutting down; the run goes on when it is back"))
        with self._guard():
            self._journal.retire(self._worker)
        self._worlds.close()

    def cancel(self, run: Run) -> None:
        """Forfeits what is left of a run.

        Raises:
            Conflict: if the run is over already.
        """
        run = self._journal.run(run.run_id)
        if run.state != RUNNING:
            raise Conflict(f"run {run.run_id!r} is {run.state.lower()} already")
        while claims := [*self._journal.open_claims(run.run_id), *self._journal.pending(run.run_id)]:
            # Whoever plays them loses them first; what ended in between is seen in the next turn.
            batch = Batch()
            for claim in self._journal.claim(run.run_id, claims, "", self._worker):
                session = self._session(run, claim)
                for _ in session.replay(self._journal.actions(run.run_id, claim.episode_id)):
                    pass
                batch.endings.append(_ending(run, session, causes.FORFEITED, "the run was cancelled"))
            self._journal.commit(batch)
        self._finish(run, CANCELLED)
        self.wake()

    def _is_busy(self) -> bool:
        return any(stream.asked or (stream.told and stream.backlog() < MAX_BACKLOG) for stream in self._streams)

    def _sweep(self) -> None:
        """Now and then: says that this worker lives, and looks for what its idle streams could do."""
        if time.monotonic() < self._next_sweep:
            return
        self._next_sweep = time.monotonic() + SWEEP_SECONDS
        asyncio.get_running_loop().call_later(1.01 * SWEEP_SECONDS, self.wake)
        with self._guard():
            self._journal.beat(self._worker, time.time(), self._address)
            self._release()
        for stream in list(self._streams):
            if len(stream.sessions) < stream.max_episodes:
                with self._guard(stream):
                    self._after_ending(stream)

    def _release(self) -> None:
        while self._to_release:
            self._journal.release(*self._to_release[0])
            self._to_release.pop(0)

    def _apply(self) -> None:
        asking = [stream for stream in self._streams if stream.asked]
        batch = Batch()
        with self._guard(*asking):
            told = [(stream, self._answers(stream, batch)) for stream in asking]
            self._journal.commit(batch)
            for stream, answers in told:
                stream.told.extend(answers)
        for stream in asking:
            if stream in self._streams and any(isinstance(event, EpisodeEnded) for event in stream.told):
                with self._guard(stream):
                    self._after_ending(stream)

    @contextmanager
    def _guard(self, *streams: Stream) -> Iterator[None]:
        """Drops the streams where the journal fails, as memory may then be ahead of it. Their clients come back."""
        try:
            yield
        except (Unavailable, Conflict, NotFound) as error:
            _log.error("%s", error)
            for stream in streams:
                self._drop(stream, error)

    def _answers(self, stream: Stream, batch: Batch) -> list[Event]:
        return [event for act in stream.asked.popleft() for event in self._answer(stream, act, batch)]

    def _answer(self, stream: Stream, act: Act, batch: Batch) -> list[Event]:
        """Applies one act in memory; what it writes goes into the batch, what it says is told after the commit."""
        session = stream.sessions.get(act.episode_id)
        if session is None:
            ended = stream.ended.get(act.episode_id)
            return [ended] if ended else [_problem(act, "NOT_YOUR_EPISODE", "this stream has no such open episode")]
        if act.forfeit is not None:
            return [self._end(stream, session, batch, causes.FORFEITED, act.forfeit[:500])]
        if act.action is None or not 0 <= act.action < len(Action):
            given = "none" if act.action is None else act.action
            return [_problem(act, "BAD_ACTION", f"the action is {given}, expected 0, 1, 2 or 3")]
        step = session.state.step
        if act.step > step:
            return [_problem(act, "STEP_AHEAD", f"step {act.step} is ahead of its turn, expected {step}")]
        if act.step < step:
            first = session.actions[act.step]
            again = self._observe(stream, session)
            if first == act.action:
                return [again]
            return [_problem(act, "STEP_BEHIND", f"step {act.step} was answered with {first:d}; that stands"), again]
        phases = session.apply(Action(act.action))
        batch.add_step(stream.run.run_id, act.episode_id, session.epoch, act.step, act.action)
        events: list[Event] = [PhaseOver(act.episode_id, phase) for phase in phases]
        if not session.state.finished:
            return [*events, self._observe(stream, session)]
        cause = causes.STEP_LIMIT if session.was_forced else causes.AGENT_FINISHED
        return [*events, self._end(stream, session, batch, cause)]

    def _end(self, stream: Stream, session: Session, batch: Batch, cause: str, note: str = "") -> EpisodeEnded:
        run_id = stream.run.run_id
        batch.endings.append(_ending(stream.run, session, cause, note))
        in_batch = sum(ending.run_id == run_id for ending in batch.endings)
        ended = EpisodeEnded(session.episode.episode_id, cause, self._journal.count_ended(run_id) + in_batch)
        stream.ended[session.episode.episode_id] = ended
        del stream.sessions[session.episode.episode_id]
        return ended

    def _after_ending(self, stream: Stream) -> None:
        """Ends the run where nothing is left of it; otherwise gives the stream its next episodes."""
        run = self._journal.run(stream.run.run_id)
        if run.state != RUNNING:
            stream.told.append(RunEnded(run, self._journal.progress(run.run_id)))
        elif not self._journal.count_unended(run.run_id):
            self._finish(run, COMPLETE)
        else:
            self._offer(stream)

    def _finish(self, run: Run, state: str) -> None:
        self._journal.set_state(run.run_id, state)
        over = RunEnded(self._journal.run(run.run_id), self._journal.progress(run.run_id))
        for stream in self._streams:
            if stream.run.run_id == run.run_id:
                stream.sessions.clear()
                stream.asked.clear()
                stream.told.append(over)

    def _tell(self, stream: Stream) -> None:
        """Gives a stream its turn."""
        if not stream.told or stream.backlog() >= MAX_BACKLOG:
            return
        events: list[Event] = []
        until = time.perf_counter() + TURN_SECONDS
        while stream.told and len(events) < TURN_EVENTS and (not events or time.perf_counter() < until):
            events.append(self._drawn(stream, stream.told.popleft()))
        stream.deliver(events)
        if any(isinstance(event, RunEnded) for event in events):
            self._streams.remove(stream)
            stream.close(None)

    def _drawn(self, stream: Stream, event: Event) -> Event:
        if not (isinstance(event, Observed) and stream.sees):
            return event
        frame = self._worlds.render(
            stream.run.split,
            event.episode,
            event.state,
            stream.image_size,
            segmentation="segmentation" in stream.run.sensors,
        )
        return replace(event, frame=frame)

    def _drop(self, stream: Stream, error: ArraMonError) -> None:
        self.leave(stream)
        stream.close(error)

    def _orphans(self, stream: Stream) -> list[Claim]:
        """Open episodes of the stream's run that it may take: its player's own, and those that others left long ago."""
        run_id, now = stream.run.run_id, time.time()
        held = {episode for other in self._streams if other.run.run_id == run_id for episode in other.sessions}

        def may_take(claim: Claim) -> bool:
            if claim.episode_id in held:
                return False
            if claim.player == stream.player:
                return True
            left = claim.worker in (None, self._worker) or now - claim.left > LEASE
            return left and (stream.adopt or now - claim.left >= self._grace)

        return [claim for claim in self._journal.open_claims(run_id) if may_take(claim)]

    def _offer(self, stream: Stream, *, first: bool = False) -> None:
        """Gives a stream episodes until it has as many as it asked for, or there are no more."""
        run_id = stream.run.run_id
        room = stream.max_episodes - len(stream.sessions)
        wanted = self._orphans(stream)[:room]
        if room > len(wanted):
            wanted += self._journal.pending(run_id, room - len(wanted))
        won = self._journal.claim(run_id, wanted, stream.player, self._worker) if wanted else []
        if first:
            back = tuple(claim.episode_id for claim in won if claim.state == OPEN)
            stream.told.append(Opened(stream.run, self._journal.progress(run_id), back))
        for claim in won:
            stream.told.extend(self._start(stream, claim, first))

    def _start(self, stream: Stream, claim: Claim, first: bool) -> list[Event]:
        """Opens an episode for a stream, rebuilt from the journal where it was played before."""
        session = self._session(stream.run, claim)
        actions = self._journal.actions(stream.run.run_id, claim.episode_id)
        scene = self._worlds.scene(stream.run.split, session.episode.section)
        started = EpisodeStarted(stream.run, session.episode, scene, len(actions))
        remembers = claim.player == stream.player and not (first and stream.history)
        past = [
            Observed(stream.run, session.episode, state, session.steps_left(state), taken=taken)
            for state, taken in session.replay(actions)
        ]
        stream.sessions[claim.episode_id] = session
        return [started, *([] if remembers else past), self._observe(stream, session)]

    def _session(self, run: Run, claim: Claim) -> Session:
        episode = self._splits[run.split].episodes[claim.episode_id]
        ground = self._worlds.ground(run.split, episode.section)
        return Session(episode, ground, Limits(run.steps_per_phase), claim.epoch)

    def _observe(self, stream: Stream, session: Session) -> Observed:
        return Observed(stream.run, session.episode, session.state, session.steps_left(session.state))


def _ending(run: Run, session: Session, cause: str, note: str = "") -> Ending:
    scores = [dict(turn) for turn in session.scores().turns]
    return Ending(run.run_id, session.episode.episode_id, cause, session.state.step, scores, note, session.epoch)


def _problem(act: Act, code: str, message: str) -> Problem:
    return Problem(code, f"episode {act.episode_id!r}: {message}", act.episode_id, act.step)

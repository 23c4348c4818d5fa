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
from server.runs.answering import Answering, ending
from server.runs.events import EpisodeEnded, Event, Observed, RunEnded
from server.runs.journal import Journal
from server.runs.offering import Offering
from server.runs.records import CANCELLED, COMPLETE, RUNNING, Batch, Run
from server.runs.stream import Act, Stream
from server.runs.worlds import Worlds
from server.sim.cameras import CAMERAS

GRACE = 10.0
"""Seconds for which an episode that a broken stream left open waits for its own player."""

TURN_SECONDS, TURN_EVENTS = 0.004, 16
"""A stream's turn: so long it is drawn for, and so many events it is told at the most, before the next one's turn."""

SWEEP_SECONDS = 1.0
"""Between two looks at what nobody asked for: signs of life, and episodes whose players did not come back."""

MAX_BACKLOG = 2 << 20
"""Bytes waiting to leave, from which on a slow reader gets nothing more drawn: eight raw observations or so."""

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
        self._journal = journal
        self._address = address
        self._worlds = Worlds(splits, camera)
        self._work = asyncio.Event()
        self._worker = uuid.uuid4().hex
        self._offering = Offering(splits, journal, self._worlds, self._worker, grace)
        self._answering = Answering(journal)
        self._streams: list[Stream] = []
        self._to_release: list[tuple[str, dict[str, int], float]] = []
        self._next_sweep = 0.0

    @property
    def worker(self) -> str:
        """This process, as the journal knows it."""
        return self._worker

    def join(self, stream: Stream) -> None:
        """A stream comes in."""
        for other in list(self._streams):
            if (other.run.run_id, other.player) == (stream.run.run_id, stream.player):
                self._drop(other, Conflict("another stream of the same player took this one's place"))
        self._streams.append(stream)
        with self._guard(stream):
            if stream.images:
                self._journal.note_images(stream.run.run_id, stream.images)
            self._offering.offer(stream, self._held(stream.run), first=True)
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
            self._to_release.append((stream.run.run_id, epochs, time.monotonic()))
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
        self._journal.beat(self._worker, self._address)

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
                session = self._offering.session(run, claim)
                for _ in session.replay(self._journal.actions(run.run_id, claim.episode_id)):
                    pass
                batch.endings.append(ending(run, session, causes.FORFEITED, "the run was cancelled"))
            self._journal.commit(batch)
        self._finish(run, CANCELLED)
        self.wake()

    def _is_busy(self) -> bool:
        return any(stream.is_asking or (stream.told and stream.backlog() < MAX_BACKLOG) for stream in self._streams)

    def _sweep(self) -> None:
        """Now and then: says that this worker lives, and looks for what its idle streams could do."""
        if time.monotonic() < self._next_sweep:
            return
        self._next_sweep = time.monotonic() + SWEEP_SECONDS
        asyncio.get_running_loop().call_later(1.01 * SWEEP_SECONDS, self.wake)
        with self._guard():
            self._journal.beat(self._worker, self._address)
            self._release()
        for stream in list(self._streams):
            if len(stream.sessions) < stream.max_episodes:
                with self._guard(stream):
                    self._after_ending(stream)

    def _release(self) -> None:
        while self._to_release:
            run_id, epochs, left_at = self._to_release[0]
            self._journal.release(run_id, epochs, ago=time.monotonic() - left_at)
            self._to_release.pop(0)

    def _apply(self) -> None:
        asking = [stream for stream in self._streams if stream.is_asking]
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
        return [event for act in stream.take() for event in self._answering.answer(stream, act, batch)]

    def _after_ending(self, stream: Stream) -> None:
        """Ends the run where nothing is left of it; otherwise gives the stream its next episodes."""
        run = self._journal.run(stream.run.run_id)
        if run.state != RUNNING:
            stream.told.append(RunEnded(run, self._journal.progress(run.run_id)))
        elif not self._journal.count_unended(run.run_id):
            self._finish(run, COMPLETE)
        else:
            self._offering.offer(stream, self._held(run))

    def _held(self, run: Run) -> set[str]:
        return {episode for other in self._streams if other.run.run_id == run.run_id for episode in other.sessions}

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

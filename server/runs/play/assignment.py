"""Assignment of episodes to streams: find free episodes, claim them, and open or reopen them."""

import time
from collections.abc import Collection, Iterator

from arramon_server.runs.play.actions import observation_of
from arramon_server.runs.play.events import EpisodeEnded, EpisodeStarted, Event, Observed, StreamOpened
from arramon_server.runs.play.faults import EpisodeFault, FaultHandler, fault_boundary
from arramon_server.runs.play.session_loader import SessionLoader
from arramon_server.runs.play.stream import AssignedEpisode, Stream
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import LEASE, OPEN, Claim

GRACE = 10.0
"""Seconds for which an episode that a broken stream left open is reserved for the same player."""

SILENT = 2.0
"""Seconds without a heartbeat, of which there is one a second, after which a worker whose player has reconnected here
counts as dead."""


class Assignment:
    """Assigns episodes to streams.

    Args:
        journal: stores the claims.
        loader: loads episodes.
        faults: handles episodes that cannot be opened.
        worker: id of this process.
        grace: seconds for which an orphaned episode is reserved for the same player.
    """

    def __init__(
        self, journal: Journal, loader: SessionLoader, faults: FaultHandler, worker: str, grace: float
    ) -> None:
        self._journal = journal
        self._loader = loader
        self._faults = faults
        self._worker = worker
        self._grace = grace

    def assign(self, stream: Stream, held: Collection[str], *, first: bool = False) -> None:
        """Claim episodes for a stream until it has `max_episodes` or no more are available.

        Args:
            stream: stream to assign to; on the first call, its outbox also gets the ids of the episodes it resumes.
            held: ids of the run's episodes that are open on streams of this process.
            first: whether the stream has just joined. If it pauses and its run is between two episodes, it gets the end
                of the latest one again, and no further one.
        """
        run_id = stream.run.run_id
        orphans = self._orphans(stream, held)
        end = self._latest_end(run_id) if first and stream.pauses and not orphans else None
        if end is not None:
            stream.note_end(end.episode_id)
        free = stream.free_slots
        wanted = orphans[:free]
        if free > len(wanted):
            wanted += self._journal.pending(run_id, free - len(wanted))
        lost = {claim.episode_id for claim in wanted if self._was_lost(claim)}
        won = self._journal.claim(run_id, wanted, stream.player, self._worker, reoffered=lost) if wanted else []
        if first:
            back = tuple(claim.episode_id for claim in won if claim.state == OPEN)
            stream.outbox.append(StreamOpened(stream.run, self._journal.progress(run_id), back))
            stream.outbox.extend([end] if end is not None else [])
        for claim in won:
            remembers = claim.player == stream.player and not (first and stream.history)
            stream.assigned[claim.episode_id] = AssignedEpisode(claim, with_history=not remembers)

    def open(self, stream: Stream, until: float) -> None:
        """Open a stream's assigned episodes until a `time.perf_counter` deadline; the next call continues."""
        while stream.can_open and time.perf_counter() < until:
            assigned = next(iter(stream.assigned.values()))
            stream.opening = stream.opening or self._open_one(stream, assigned)
            try:
                with fault_boundary(stream.run, assigned.claim, "opening"):
                    for _ in stream.opening:
                        if time.perf_counter() >= until:
                            return
            except EpisodeFault:
                self._faults.handle(stream, assigned.claim)

    def _orphans(self, stream: Stream, held: Collection[str]) -> list[Claim]:
        """Return the open episodes that a stream may take: its player's own, and those that other players abandoned."""

        def may_take(claim: Claim) -> bool:
            if claim.episode_id in held:
                return False
            if claim.player == stream.player:
                return True
            left = claim.worker in (None, self._worker) or claim.idle > LEASE
            return left and (stream.adopt or claim.idle >= self._grace)

        return [claim for claim in self._journal.open_claims(stream.run.run_id) if may_take(claim)]

    def _latest_end(self, run_id: str) -> EpisodeEnded | None:
        """Return the end of a run's latest ended episode if others have not ended; otherwise None."""
        endings = self._journal.endings(run_id)
        if not endings or not self._journal.count_unended(run_id):
            return None
        return EpisodeEnded(endings[-1].episode_id, endings[-1].cause, len(endings))

    def _was_lost(self, claim: Claim) -> bool:
        """Return whether the process that held an episode died, so that offering it again is the server's fault."""
        return claim.worker not in (None, self._worker) and claim.idle > SILENT

    def _open_one(self, stream: Stream, assigned: AssignedEpisode) -> Iterator[None]:
        """Open an episode: load its world, one part per iteration, then replay its recorded actions, one each."""
        run, claim = stream.run, assigned.claim
        for _ in self._loader.load_world(run, claim, drawn=stream.wants_images):
            yield
        world = self._loader.world(run, claim)
        session = self._loader.begin(run, claim)
        actions = self._loader.actions(run, claim)
        notes = self._loader.notes(run, claim) if assigned.with_history else {}
        past: list[Event] = []
        for state, taken in session.replay(actions):
            if assigned.with_history:
                left, note = session.steps_left(state), notes.get(state.step)
                past.append(Observed(run, session.episode, world, state, left, taken=taken, taken_note=note))
            yield
        started = EpisodeStarted(run, session.episode, world.scene, len(actions))
        stream.drop(claim.episode_id)
        stream.sessions[claim.episode_id], stream.worlds[claim.episode_id] = session, world
        if claim.state == OPEN:
            session.thinking.skip(session.state.step)
        if stream.clock is not None:
            step = session.state.step
            stream.clock.open(claim.episode_id, step, claim.seconds_waited(step))
        stream.outbox.extend((started, *past, observation_of(stream, session)))

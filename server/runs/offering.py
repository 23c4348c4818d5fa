"""Which episodes a stream is offered: finds them, claims them, and opens them from the journal."""

import time
from collections.abc import Collection, Iterator

from server.runs.answering import observed
from server.runs.events import EpisodeStarted, Event, Observed, Opened
from server.runs.faults import EpisodeFault, Faults, contained
from server.runs.journal import Journal
from server.runs.opening import Opening
from server.runs.records import LEASE, OPEN, Claim
from server.runs.stream import Coming, Stream

SILENT = 2.0
"""Seconds without the sign of life that a worker gives each second: if its own player comes to another, it has died."""


class Offering:
    """Offers episodes.

    Args:
        journal: says who holds what.
        opening: opens them.
        faults: takes those that cannot be opened.
        worker: this process.
        grace: seconds for which an orphaned episode waits for its player.
    """

    def __init__(self, journal: Journal, opening: Opening, faults: Faults, worker: str, grace: float) -> None:
        self._journal = journal
        self._opening = opening
        self._faults = faults
        self._worker = worker
        self._grace = grace

    def offer(self, stream: Stream, held: Collection[str], *, first: bool = False) -> None:
        """Gives a stream episodes until it has as many as it asked for, or there are no more.

        Args:
            stream: is told of them.
            held: episodes of its run that streams of this process have open.
            first: whether the stream has only just come.
        """
        run_id = stream.run.run_id
        room = stream.room
        wanted = self._orphans(stream, held)[:room]
        if room > len(wanted):
            wanted += self._journal.pending(run_id, room - len(wanted))
        lost = {claim.episode_id for claim in wanted if self._has_lost(claim)}
        won = self._journal.claim(run_id, wanted, stream.player, self._worker, reoffered=lost) if wanted else []
        if first:
            back = tuple(claim.episode_id for claim in won if claim.state == OPEN)
            stream.told.append(Opened(stream.run, self._journal.progress(run_id), back))
        for claim in won:
            remembers = claim.player == stream.player and not (first and stream.history)
            stream.coming[claim.episode_id] = Coming(claim, with_past=not remembers)

    def open(self, stream: Stream, until: float) -> None:
        """Opens what is coming to a stream, until a time by `time.perf_counter`: it may stop in the middle of one."""
        while stream.can_open and time.perf_counter() < until:
            coming = next(iter(stream.coming.values()))
            stream.opening = stream.opening or self._start(stream, coming)
            try:
                with contained(stream.run, coming.claim, "opening"):
                    for _ in stream.opening:
                        if time.perf_counter() >= until:
                            return
            except EpisodeFault:
                self._faults.take(stream, coming.claim)

    def _orphans(self, stream: Stream, held: Collection[str]) -> list[Claim]:
        """Open episodes of the stream's run that it may take: its player's own, and those that others left long ago."""

        def may_take(claim: Claim) -> bool:
            if claim.episode_id in held:
                return False
            if claim.player == stream.player:
                return True
            left = claim.worker in (None, self._worker) or claim.idle > LEASE
            return left and (stream.adopt or claim.idle >= self._grace)

        return [claim for claim in self._journal.open_claims(stream.run.run_id) if may_take(claim)]

    def _has_lost(self, claim: Claim) -> bool:
        """Whether a process died that had the episode: what is offered again by that is the server's fault."""
        return claim.worker not in (None, self._worker) and claim.idle > SILENT

    def _start(self, stream: Stream, coming: Coming) -> Iterator[None]:
        """Opens an episode for a stream, rebuilt from the journal where it was played before, a step at a time."""
        run, claim = stream.run, coming.claim
        session = self._opening.begun(run, claim)
        actions = self._opening.actions(run, claim)
        past: list[Event] = []
        for state, taken in session.replay(actions):
            if coming.with_past:
                past.append(Observed(run, session.episode, state, session.steps_left(state), taken=taken))
            yield
        started = EpisodeStarted(run, session.episode, self._opening.scene(run, session.episode), len(actions))
        stream.drop(claim.episode_id)
        stream.sessions[claim.episode_id] = session
        if stream.clock is not None:
            away = claim.idle if claim.worker is None else 0.0  # a worker that has died is the server's own absence
            stream.clock.open(claim.episode_id, claim.waited, away if claim.state == OPEN else None)
        stream.told.extend((started, *past, observed(stream, session)))

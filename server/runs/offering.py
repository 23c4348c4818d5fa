"""Which episodes a stream is offered: finds them, claims them, and opens them from the journal."""

from collections.abc import Collection, Mapping

from server.episodes.splits import Split
from server.runs.answering import observed
from server.runs.events import EpisodeStarted, Event, Observed, Opened
from server.runs.journal import Journal
from server.runs.records import OPEN, Claim, Run
from server.runs.session import Session
from server.runs.stream import Stream
from server.runs.worlds import Worlds
from server.sim.rules import Limits

LEASE = 5.0
"""Seconds after its last sign of life from which on a worker counts as dead, and what it held as left."""


class Offering:
    """Offers episodes.

    Args:
        splits: by name.
        journal: says who holds what.
        worlds: in which they are played.
        worker: this process.
        grace: seconds for which an orphaned episode waits for its player.
    """

    def __init__(
        self, splits: Mapping[str, Split], journal: Journal, worlds: Worlds, worker: str, grace: float
    ) -> None:
        self._splits = splits
        self._journal = journal
        self._worlds = worlds
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
        room = stream.max_episodes - len(stream.sessions)
        wanted = self._orphans(stream, held)[:room]
        if room > len(wanted):
            wanted += self._journal.pending(run_id, room - len(wanted))
        won = self._journal.claim(run_id, wanted, stream.player, self._worker) if wanted else []
        if first:
            back = tuple(claim.episode_id for claim in won if claim.state == OPEN)
            stream.told.append(Opened(stream.run, self._journal.progress(run_id), back))
        for claim in won:
            stream.told.extend(self._start(stream, claim, first))

    def session(self, run: Run, claim: Claim) -> Session:
        """A session of an episode, at its beginning."""
        episode = self._splits[run.split].episodes[claim.episode_id]
        ground = self._worlds.ground(run.split, episode.section)
        return Session(episode, ground, Limits(run.steps_per_phase), claim.epoch)

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

    def _start(self, stream: Stream, claim: Claim, first: bool) -> list[Event]:
        """Opens an episode for a stream, rebuilt from the journal where it was played before."""
        session = self.session(stream.run, claim)
        actions = self._journal.actions(stream.run.run_id, claim.episode_id)
        scene = self._worlds.scene(stream.run.split, session.episode.section)
        started = EpisodeStarted(stream.run, session.episode, scene, len(actions))
        remembers = claim.player == stream.player and not (first and stream.history)
        past = [
            Observed(stream.run, session.episode, state, session.steps_left(state), taken=taken)
            for state, taken in session.replay(actions)
        ]
        stream.sessions[claim.episode_id] = session
        return [started, *([] if remembers else past), observed(stream, session)]

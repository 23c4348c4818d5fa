"""Loader of episodes to play: new ones, and ones rebuilt from the journal."""

from collections.abc import Iterator, Mapping

from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import OPEN, Claim, Run
from arramon_server.sim.rules import Limits
from arramon_server.sim.section_world import EpisodeWorld


class SessionLoader:
    """Loads episodes of runs for play.

    Args:
        splits: splits by name.
        journal: stores the recorded actions.
        worlds: loads the worlds of episodes.
    """

    def __init__(self, splits: Mapping[str, Split], journal: Journal, worlds: Worlds) -> None:
        self._splits = splits
        self._journal = journal
        self._worlds = worlds

    def has_data(self, run: Run) -> bool:
        """Return whether this server has the data with which a run was created."""
        split = self._splits.get(run.split)
        return split is not None and split.data_hash == run.data_hash

    def episode(self, run: Run, claim: Claim) -> Episode:
        """Return the claimed episode."""
        return self._splits[run.split].episodes[claim.episode_id]

    def load_world(self, run: Run, claim: Claim, *, drawn: bool) -> Iterator[object]:
        """Load the world of the claimed episode part by part, as `Worlds.load` does."""
        return self._worlds.load(run.split, self.episode(run, claim), drawn=drawn)

    def world(self, run: Run, claim: Claim) -> EpisodeWorld:
        """Return the world of the claimed episode."""
        return self._worlds.world(run.split, self.episode(run, claim))

    def begin(self, run: Run, claim: Claim) -> EpisodeSession:
        """Return a session at the beginning of its episode."""
        return EpisodeSession(
            self.episode(run, claim), self.world(run, claim), Limits(run.steps_per_phase), claim.fence
        )

    def actions(self, run: Run, claim: Claim) -> list[int]:
        """Return the recorded actions of an open episode; none for one that has not begun."""
        return self._journal.actions(run.run_id, claim.episode_id) if claim.state == OPEN else []

    def notes(self, run: Run, claim: Claim) -> dict[int, str]:
        """Return the notes of an open episode by step; none for one that has not begun."""
        return self._journal.notes_of(run.run_id, claim.episode_id) if claim.state == OPEN else {}

    def replay(self, run: Run, claim: Claim) -> EpisodeSession:
        """Return a session with all recorded actions applied."""
        session = self.begin(run, claim)
        for _ in session.replay(self.actions(run, claim)):
            pass
        return session

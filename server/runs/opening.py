"""Opens an episode of a run: as it begins, or as far as the journal knows it to have been played."""

from collections.abc import Mapping

from server.episodes.episode import Episode
from server.episodes.splits import Split
from server.runs.journal import Journal
from server.runs.records import OPEN, Claim, Run
from server.runs.session import Session
from server.runs.worlds import Worlds
from server.sim.rules import Limits
from server.sim.scene import Scene


class Opening:
    """Opens episodes.

    Args:
        splits: by name.
        journal: holds what was played.
        worlds: in which they are played.
    """

    def __init__(self, splits: Mapping[str, Split], journal: Journal, worlds: Worlds) -> None:
        self._splits = splits
        self._journal = journal
        self._worlds = worlds

    def episode(self, run: Run, claim: Claim) -> Episode:
        """The episode itself."""
        return self._splits[run.split].episodes[claim.episode_id]

    def scene(self, run: Run, episode: Episode) -> Scene:
        """Of the episode's section."""
        return self._worlds.scene(run.split, episode.section)

    def begun(self, run: Run, claim: Claim) -> Session:
        """The episode at its beginning."""
        episode = self.episode(run, claim)
        ground = self._worlds.ground(run.split, episode.section)
        return Session(episode, ground, Limits(run.steps_per_phase), claim.epoch)

    def actions(self, run: Run, claim: Claim) -> list[int]:
        """What was played of it."""
        return self._journal.actions(run.run_id, claim.episode_id) if claim.state == OPEN else []

    def played(self, run: Run, claim: Claim) -> Session:
        """The episode as far as it was played."""
        session = self.begun(run, claim)
        for _ in session.replay(self.actions(run, claim)):
            pass
        return session

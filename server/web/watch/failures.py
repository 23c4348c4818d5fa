"""Outcomes of a run's turns, found by replaying all of its episodes once, and cached."""

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from threading import Lock

from arramon_server.board.standings import Entry, ScoresVersion
from arramon_server.episodes.splits import Split
from arramon_server.playback.outcomes import outcomes_of
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import EpisodeEnding, Run
from arramon_server.scoring.turn_outcomes import TurnOutcome
from arramon_server.sim.footprints import Footprints
from arramon_server.sim.rules import Limits

CACHED_RUNS = 64
"""Number of runs whose outcomes are cached."""


@dataclass(frozen=True, slots=True)
class EpisodeOutcome:
    """An episode of a run with its outcome.

    Attributes:
        ending: how it ended.
        turns: outcomes of both turns.
    """

    ending: EpisodeEnding
    turns: tuple[TurnOutcome, TurnOutcome]

    @property
    def ndtw(self) -> float:
        """Mean nDTW of both turns."""
        return sum(turn["nDTW"] for turn in self.ending.scores) / len(self.ending.scores)


class RunFailures:
    """Outcomes of the turns of ended runs on open splits. Thread-safe; the first call for a run is slow.

    Args:
        splits: the splits served, by name.
        journal: source of the actions.
    """

    def __init__(self, splits: Mapping[str, Split], journal: Journal) -> None:
        self._splits = splits
        self._journal = journal
        self._kept = OrderedDict[ScoresVersion, tuple[EpisodeOutcome, ...]]()
        self._lock = Lock()

    def of(self, run: Run, entry: Entry | None) -> tuple[EpisodeOutcome, ...]:
        """Return the outcomes of a run's episodes, in playing order.

        Args:
            run: the run, which has ended.
            entry: its entry on the leaderboard; None if it is not published.
        """
        version = ScoresVersion(run.run_id) if entry is None else entry.version
        with self._lock:
            if version not in self._kept:
                self._kept[version] = self._outcomes(run)
                if len(self._kept) > CACHED_RUNS:
                    self._kept.popitem(last=False)
            return self._kept[version]

    def _outcomes(self, run: Run) -> tuple[EpisodeOutcome, ...]:
        split, worlds = self._splits[run.split], Worlds(self._splits, physics=Footprints)
        found = list[EpisodeOutcome]()
        for ending in self._journal.endings(run.run_id):
            episode = split.episodes[ending.episode_id]
            turns = outcomes_of(
                episode,
                worlds.world(run.split, episode),
                Limits(run.steps_per_phase),
                self._journal.actions(run.run_id, ending.episode_id) if ending.has_played else (),
                timed_out=ending.cause == causes.TIME_LIMIT,
            )
            found.append(EpisodeOutcome(ending, turns))
        return tuple(found)

"""Breakdown of a run's scores by what the instructions ask for."""

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from arramon_server.episodes.splits import Split
from arramon_server.runs.results.reports import score_array, split_as_played, without_void
from arramon_server.runs.results.turn_groups import TRAIN, TurnGroup, TurnGrouping, group_turns
from arramon_server.runs.storage.records import EpisodeEnding, Run
from arramon_server.scoring.breakdown import GroupScores, group_scores, masked_group_scores
from arramon_server.scoring.masking import Noise, digest_without, masked_rows

_KEPT = 32
"""Number of cached groupings, one per split and language, about 200 KB each."""


@dataclass(frozen=True, slots=True)
class BreakdownLine:
    """The scores of a run on a group of turns."""

    group: TurnGroup
    found: GroupScores


@dataclass(frozen=True, slots=True)
class Breakdown:
    """A run's scores by groups of turns.

    Attributes:
        lines: scores by group, in the order of `turn_groups.ASPECTS`.
        withheld: number of groups that are not shown, as they would reveal single episodes of a hidden split.
        rounded: whether the scores are masked, as on every hidden split, see `scoring.masking`.
        knows_demands: whether it is known what the instructions ask for; otherwise groups by these are missing.
    """

    lines: tuple[BreakdownLine, ...]
    withheld: int
    rounded: bool
    knows_demands: bool


class Breakdowns:
    """Breaks down the scores of runs. Thread-safe.

    Args:
        splits: served splits, by name.
        play_digest_of: returns the play digest of a run, see `Journal.play_digest`.
    """

    def __init__(self, splits: Mapping[str, Split], play_digest_of: Callable[[Run], str]) -> None:
        self._splits = splits
        self._play_of = play_digest_of
        self._grouping = lru_cache(_KEPT)(self._make_grouping)

    def of(self, run: Run, endings: Sequence[EpisodeEnding], voided: Set[str] = frozenset()) -> Breakdown:
        """Return the breakdown of a run that has ended.

        Args:
            run: the run.
            endings: endings of all its episodes.
            voided: ids of the split's episodes that are void.

        Raises:
            Conflict: if the data of its split has changed since it was created, or all its episodes are void.
        """
        split = split_as_played(run, self._splits)
        groups = self._grouping(run.split, run.language)
        ordered = sorted(without_void(run, endings, voided), key=lambda ending: ending.episode_id)
        rows = np.searchsorted(groups.ids, [ending.episode_id for ending in ordered])
        scores = score_array(ordered)
        found = [(group, group.turns[rows]) for group in groups.groups if group.turns[rows].any()]
        if split.hidden:
            noise = Noise(split.truth_hash)
            name = digest_without(self._play_of(run), voided & {ending.episode_id for ending in endings})
            table = masked_rows(scores, noise, name)
            lines = [
                BreakdownLine(group, masked_group_scores(scores, turns, table, noise, (name, *group.names)))
                for group, turns in found
            ]
        else:
            names = [split.episodes[ending.episode_id].section for ending in ordered]
            sections = np.unique(names, return_inverse=True)[1]
            lines = [BreakdownLine(group, group_scores(scores, turns, sections)) for group, turns in found]
        return Breakdown(tuple(lines), groups.withheld, split.hidden, groups.knows_demands)

    def _make_grouping(self, split: str, language: str) -> TurnGrouping:
        return group_turns(self._splits[split], language, self._splits.get(TRAIN))

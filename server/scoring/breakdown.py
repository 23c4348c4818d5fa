"""Scores of groups of turns, with intervals that treat both turns of an episode as dependent."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_server.scoring.aggregate import ROWS, Interval
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.scoring.intervals import Floats, episode_moments, mean_bounds
from arramon_server.scoring.masking import Noise, Rows, masked_group

SHOWN = ("nDTW", "CTC-3", "rPOD", "PTC", "PTC@CTC-3")
"""Metrics of a breakdown: the navigation phase alone, the assembly phase alone (not gated), and both together."""


@dataclass(frozen=True, slots=True)
class GroupScores:
    """Scores of a group of turns.

    Attributes:
        turns: number of the turns.
        episodes: number of the episodes that they belong to.
        scores: metric of SHOWN -> mean over the turns, with its interval.
    """

    turns: int
    episodes: int
    scores: Mapping[str, Interval]


def group_scores(scores: Floats, group: npt.NDArray[np.bool_], sections: npt.NDArray[np.intp]) -> GroupScores:
    """Return the scores of a group of turns.

    The mean is a ratio: the sum of the scores over the number of turns. Its variance is computed from each episode's
    share in both, so that two turns of one episode do not count as independent.

    Args:
        scores: scores of all turns, (episodes, 2, METRICS).
        group: the turns in the group, at least one, (episodes, 2).
        sections: number of each episode's section from 0, (episodes,).
    """
    chosen = np.flatnonzero(group.any(axis=1))
    taken, where = group[chosen], sections[chosen]
    counts = taken.sum(axis=1)
    sums = (scores[chosen] * taken[:, :, None]).sum(axis=1)
    turns = int(counts.sum())
    means = sums.sum(axis=0) / turns
    shares = means + (sums - means * counts[:, None]) * (len(chosen) / turns)  # their mean is that of the turns
    bounds = mean_bounds(episode_moments(shares, np.unique(where, return_inverse=True)[1]))
    found = {}
    for metric in SHOWN:
        column = METRICS.index(metric)
        # Rounding errors may leave a share of nothing just outside.
        mean = min(max(float(bounds.mean[column]), 0.0), 1.0)
        found[metric] = Interval(mean, min(float(bounds.low[column]), mean), max(float(bounds.high[column]), mean))
    return GroupScores(turns, len(chosen), found)


def masked_group_scores(
    scores: Floats, group: npt.NDArray[np.bool_], rows: Rows, noise: Noise, names: Sequence[str]
) -> GroupScores:
    """Return the masked scores of a group of turns of a hidden split.

    Args:
        scores: scores of all turns, (episodes, 2, METRICS).
        group: the turns in the group, at least one, (episodes, 2).
        rows: shown rows of the run's score table; a group of all first, or all second turns shows the same figures.
        noise: noise of the split.
        names: digest of the play, and what names the group.
    """
    turns, episodes = int(group.sum()), int(group.any(axis=1).sum())
    if (group == group[0]).all():
        row = ROWS[2] if group.all() else ROWS[int(group[0, 1])]
        return GroupScores(turns, episodes, {metric: rows[row][metric] for metric in SHOWN})
    return GroupScores(turns, episodes, masked_group(scores, group, SHOWN, noise, names))

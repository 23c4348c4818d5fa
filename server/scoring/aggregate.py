"""Aggregation of episode scores to a table of means with bootstrap confidence intervals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from server.scoring.episode import METRICS, EpisodeScores

ROWS = ("turn 1", "turn 2", "total")


@dataclass(frozen=True, slots=True)
class Interval:
    """A mean and its confidence interval.

    Attributes:
        mean: mean over the episodes.
        low: lower end of the interval; never above the mean.
        high: upper end of the interval; never below the mean.
    """

    mean: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class ScoreTable:
    """The score table of a run.

    Attributes:
        rows: row name of ROWS -> metric name of METRICS -> value.
        episodes: number of episodes, the denominator of the means.
        clustered: whether sections rather than episodes were resampled.
    """

    rows: Mapping[str, Mapping[str, Interval]]
    episodes: int
    clustered: bool


def aggregate(
    episodes: Sequence[EpisodeScores], *, resamples: int = 1000, confidence: float = 0.95, seed: int = 0
) -> ScoreTable:
    """Return means over all episodes, per turn and over both turns, with percentile bootstrap intervals.

    If the episodes come from several sections, whole sections are resampled with all their episodes, since episodes of
    one section are alike; otherwise episodes are resampled. The result does not depend on the order of `episodes`.

    Args:
        episodes: scores of every episode of the run, including those that were not played.
        resamples: number of resamples.
        confidence: share of the resampled means that an interval spans.
        seed: seed of the resampling.

    Raises:
        ValueError: if there are no episodes.
    """
    if not episodes:
        raise ValueError("no episodes to aggregate; expected at least one")
    ordered = sorted(episodes, key=lambda episode: episode.episode_id)
    turns = np.array([[[turn[name] for name in METRICS] for turn in episode.turns] for episode in ordered])
    values = np.concatenate([turns, turns.mean(axis=1, keepdims=True)], axis=1)  # (episodes, rows, metrics)
    sections, section_of = np.unique([episode.section for episode in ordered], return_inverse=True)
    clustered = len(sections) > 1
    clusters = section_of if clustered else np.arange(len(ordered))

    means = values.mean(axis=0)
    drawn = _resampled_means(values, clusters, resamples, seed)
    tail = (1.0 - confidence) / 2.0
    low, high = np.quantile(drawn, (tail, 1.0 - tail), axis=0)
    low, high = np.minimum(low, means), np.maximum(high, means)
    rows = {
        row: {
            metric: Interval(float(means[r, m]), float(low[r, m]), float(high[r, m]))
            for m, metric in enumerate(METRICS)
        }
        for r, row in enumerate(ROWS)
    }
    return ScoreTable(rows, len(ordered), clustered)


def _resampled_means(
    values: npt.NDArray[np.float64], clusters: npt.NDArray[np.intp], resamples: int, seed: int
) -> npt.NDArray[np.float64]:
    """Return the mean of `values` (episodes, ...) in each of `resamples` draws of whole clusters with replacement.

    A draw is a vector of the counts of each cluster, so that two matrix products give all means.
    """
    sizes = np.bincount(clusters)
    flat = values.reshape(len(values), -1)
    sums = np.zeros((len(sizes), flat.shape[1]))
    np.add.at(sums, clusters, flat)
    counts = np.random.default_rng(seed).multinomial(len(sizes), np.full(len(sizes), 1.0 / len(sizes)), size=resamples)
    means = (counts @ sums) / (counts @ sizes)[:, None]
    return means.reshape(resamples, *values.shape[1:])

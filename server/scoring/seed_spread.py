"""Variance between runs of one agent with different seeds, separated from the variance between episodes.

All runs played the same episodes, so that scores have two factors: run and episode. Their variance components follow
from the mean squares of a two-way analysis of variance with one score in each cell (Searle, Casella and McCulloch
1992).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from arramon_server.scoring.intervals import CONFIDENCE, Floats


@dataclass(frozen=True, slots=True)
class SeedSpread:
    """Spread of a mean over runs with several seeds.

    Attributes:
        runs: number of runs.
        deviation: standard deviation between the true means of runs on these episodes, as estimated; at least 0. On a
            hidden split it contains the error of each run's shown mean.
        episodes_deviation: standard deviation between episodes, over runs; at least 0. None on a hidden split.
        rest_deviation: standard deviation of what neither explains: an episode solved with one seed, not with another.
            None on a hidden split.
        low, high: 95% interval for the mean over other seeds, on these episodes; within [0, 1].
    """

    runs: int
    deviation: float
    episodes_deviation: float | None
    rest_deviation: float | None
    low: float
    high: float


def seed_spread(scores: Floats, confidence: float = CONFIDENCE) -> SeedSpread:
    """Return the spread of runs with several seeds.

    The interval is Student's, from the means of the runs: with few of them it is wide. It includes randomness within a
    run, which another seed would draw anew.

    Args:
        scores: score of each run in each episode, (runs, episodes); at least two runs, and two episodes.
        confidence: nominal coverage of the interval.
    """
    runs, episodes = scores.shape
    mean, of_runs, of_episodes = scores.mean(), scores.mean(axis=1), scores.mean(axis=0)
    rest = scores - of_runs[:, None] - of_episodes + mean
    squares = float((rest**2).sum()) / ((runs - 1) * (episodes - 1))
    between = episodes * float(of_runs.var(ddof=1))
    among = runs * float(of_episodes.var(ddof=1))
    half = float(stdtrit(runs - 1, 0.5 + confidence / 2.0)) * float(of_runs.std(ddof=1)) / runs**0.5
    return SeedSpread(
        runs,
        max(between - squares, 0.0) ** 0.5 / episodes**0.5,
        max(among - squares, 0.0) ** 0.5 / runs**0.5,
        squares**0.5,
        max(float(mean) - half, 0.0),
        min(float(mean) + half, 1.0),
    )


def masked_spread(means: Sequence[float], confidence: float = CONFIDENCE) -> SeedSpread:
    """Return the spread of runs with several seeds on a hidden split, from their shown means alone.

    Args:
        means: shown mean of each run, at least two.
        confidence: nominal coverage of the interval.
    """
    values = np.array(means)
    mean, deviation = float(values.mean()), float(values.std(ddof=1))
    half = float(stdtrit(len(values) - 1, 0.5 + confidence / 2.0)) * deviation / len(values) ** 0.5
    low, high = max(mean - half, 0.0), min(mean + half, 1.0)
    return SeedSpread(len(values), round(deviation, 4), None, None, round(low, 4), round(high, 4))

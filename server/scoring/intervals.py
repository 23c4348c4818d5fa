"""Confidence intervals for means of scores in [0, 1]: over the episodes of given sections, and over sections.

The variance is estimated from the scores, and expressed as a share of the largest variance that scores in [0, 1] with
the same mean can have. The interval contains every mean within t standard errors of the observed one, with the
standard error under that mean: Wilson's interval (1927) with an effective number of episodes (Korn and
Graubard 1998). It stays within [0, 1], and has its nominal coverage near both ends, too, unlike the
bootstrap. `benchmarks/leaderboard/interval_coverage.py` measures the coverage.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

CONFIDENCE = 0.95

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Bounds:
    """Means of several scores, and the ends of their intervals; arrays of one shape, with low <= mean <= high."""

    mean: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True, slots=True)
class Moments:
    """Mean of scores over given sections, with the sampling error of drawing episodes within the sections.

    Attributes:
        mean: mean over all episodes.
        variance: variance of the mean.
        episodes: number of episodes.
        freedom: degrees of freedom of the variance.
    """

    mean: Floats
    variance: Floats
    episodes: int
    freedom: int


def episode_moments(values: Floats, strata: npt.NDArray[np.intp]) -> Moments:
    """Return the mean over all episodes, and its variance for episodes drawn anew within each stratum.

    Strata of one episode show no variance, and are merged into one.

    Args:
        values: scores, (episodes, ...).
        strata: number of each episode's stratum from 0, (episodes,): a section, or a part of one.
    """
    sizes = np.bincount(strata)
    merged = np.where(sizes[strata] > 1, strata, len(sizes))
    _, groups, sizes = np.unique(merged, return_inverse=True, return_counts=True)
    flat = values.reshape(len(values), -1)
    means = _grouped(flat, groups, len(sizes)) / sizes[:, None]
    squares = _grouped((flat - means[groups]) ** 2, groups, len(sizes))
    spread = np.where(sizes > 1, sizes / np.maximum(sizes - 1, 1), 1.0)[:, None]  # unbiased within each stratum
    variance = (squares * spread).sum(axis=0) / len(values) ** 2
    shape = values.shape[1:]
    return Moments(values.mean(axis=0), variance.reshape(shape), len(values), max(int((sizes - 1).sum()), 0))


def mean_bounds(moments: Moments, confidence: float = CONFIDENCE) -> Bounds:
    """Return intervals for means over other episodes drawn in the same sections.

    The share of the largest variance is estimated with one more episode that has all of it. That matters only if there
    are few episodes, or if equal scores show no variance.
    """
    mean, number = moments.mean, moments.episodes
    largest = mean * (1.0 - mean)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(largest > 0.0, moments.variance * number / largest, 1.0)
    share = (share * moments.freedom + 1.0) / (moments.freedom + 1.0)
    return _score_bounds(mean, share / number, moments.freedom, confidence)


def section_bounds(values: Floats, sections: npt.NDArray[np.intp], confidence: float = CONFIDENCE) -> Bounds | None:
    """Return intervals for the mean over other sections; None with one section.

    The sections' means are the observations, with as many degrees of freedom as sections less one: with few sections
    the interval is wide.

    Args:
        values: scores, (episodes, ...).
        sections: number of each episode's section from 0, (episodes,).
        confidence: nominal coverage.
    """
    means = section_means(values, sections)
    number = len(means)
    if number < 2:
        return None
    mean = means.mean(axis=0)
    largest = mean * (1.0 - mean)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(largest > 0.0, means.var(axis=0, ddof=1) / largest, 0.0)
    # Sections that show no difference at all still have the error of their episodes.
    moments = episode_moments(values, sections)
    with np.errstate(divide="ignore", invalid="ignore"):
        least = np.where(largest > 0.0, moments.variance / largest, 1.0 / moments.episodes)
    return _score_bounds(mean, np.where(share > 0.0, share / number, least), number - 1, confidence)


def section_means(values: Floats, sections: npt.NDArray[np.intp]) -> Floats:
    """Return the mean of each section, (sections, ...)."""
    sizes = np.bincount(sections)
    flat = _grouped(values.reshape(len(values), -1), sections, len(sizes)) / sizes[:, None]
    return flat.reshape(len(sizes), *values.shape[1:])


def section_spread(values: Floats, sections: npt.NDArray[np.intp]) -> Floats | None:
    """Return the standard deviation between sections, without the sampling error of episodes; None with one section."""
    means = section_means(values, sections)
    if len(means) < 2:
        return None
    within = np.stack(
        [
            values[sections == number].var(axis=0, ddof=1) / max(int((sections == number).sum()), 1)
            if (sections == number).sum() > 1
            else np.zeros(values.shape[1:])
            for number in range(len(means))
        ]
    )
    between: Floats = np.sqrt(np.maximum(means.var(axis=0, ddof=1) - within.mean(axis=0), 0.0))
    return between


def _score_bounds(mean: Floats, share: Floats, freedom: int, confidence: float) -> Bounds:
    """Return the interval of all means m with |mean - m| <= t sqrt(m (1 - m) share)."""
    if freedom < 1:
        return Bounds(mean, np.zeros_like(mean), np.ones_like(mean))
    weight = stdtrit(freedom, 0.5 + confidence / 2.0) ** 2 * share
    centre = (mean + weight / 2.0) / (1.0 + weight)
    half = np.sqrt(weight * mean * (1.0 - mean) + weight**2 / 4.0) / (1.0 + weight)
    low, high = np.clip(centre - half, 0.0, 1.0), np.clip(centre + half, 0.0, 1.0)
    return Bounds(mean, np.minimum(low, mean), np.maximum(high, mean))


def _grouped(values: Floats, groups: npt.NDArray[np.intp], number: int) -> Floats:
    """Return sums of rows by group, (groups, columns)."""
    sums = np.zeros((number, values.shape[1]))
    np.add.at(sums, groups, values)
    return sums

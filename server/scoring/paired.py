"""Paired comparisons of runs on the same episodes: permutation tests, Holm's correction, and intervals of differences.

Under the null hypothesis two runs are exchangeable within each episode, so that the sign of each episode's difference
is random (Fisher 1935; Noreen 1989 calls it approximate randomisation). One matrix of random signs serves all pairs:
the signed sum of a pair's differences is the difference of two signed sums of scores. Where so few random sums reach
the observed one that their number says little, the tail comes from the saddlepoint approximation of the same
distribution (Robinson 1982); more than FAR standard deviations away, from Hoeffding's bound, which no tail exceeds.
`benchmarks/leaderboard/interval_coverage.py` measures false claims and power.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr, stdtrit

from arramon_server.scoring.intervals import CONFIDENCE, Floats, episode_moments

FLIPS = 10_000
"""Number of random signs of each episode."""

FEW = 20
"""Number of random sums that reach the observed one, up to which the saddlepoint approximation takes over."""

FAR = 7.0
"""Standard deviations of the random sums from which Hoeffding's bound, then below 5e-11, is taken for the tail."""

_EXACT = 1e-9
"""Difference up to which sums of scores count as equal."""

_NEWTON = 60
"""Maximum number of Newton steps to find a saddlepoint."""


@dataclass(frozen=True, slots=True)
class MeanDifference:
    """Difference of two runs' means on the same episodes.

    Attributes:
        mean: mean of the first run minus that of the second.
        low, high: 95% interval of the difference, in [-1, 1].
        p: two-sided p-value of the permutation test, not corrected for other comparisons.
    """

    mean: float
    low: float
    high: float
    p: float


def permutation_tests(scores: Floats, *, flips: int = FLIPS, seed: int = 0) -> Floats:
    """Return the two-sided p-values of all pairs of runs, (runs, runs); symmetric, with ones on the diagonal.

    Args:
        scores: score of each run in each episode, (runs, episodes); the mean over languages is one score.
        flips: number of random signs of each episode.
        seed: seed of the signs.
    """
    runs, episodes = scores.shape
    centred = scores - scores.mean(axis=0)  # the differences stay; float32 keeps more of their digits
    signs = _signs(episodes, flips, seed)
    flips, own = (
        len(signs),
        int(len(signs) < 2**episodes),
    )  # the signs as observed count once more, unless all are there
    sums = np.empty((runs, flips), dtype=np.float32)
    for start in range(0, len(signs), 2000):
        part = (signs[start : start + 2000].astype(np.float32) * 2.0 - 1.0) @ centred.T.astype(np.float32)
        sums[:, start : start + 2000] = part.T
    totals, products = centred.sum(axis=1), centred @ centred.T
    squares = np.diag(products)
    p = np.ones((runs, runs))
    for i in range(runs - 1):
        others = np.arange(i + 1, runs)
        observed = np.abs(totals[i] - totals[others])
        variance = np.maximum(squares[i] + squares[others] - 2.0 * products[i, others], _EXACT)  # of the random sums
        distance = observed**2 / variance
        found = 2.0 * np.exp(-distance / 2.0)
        near = np.flatnonzero((distance < FAR**2) | (own == 0))
        # A sum that equals the observed one reaches it: float32 rounds at about 1e-6 of the sums.
        gaps = np.abs(sums[i] - sums[others[near]])
        reached = np.count_nonzero(gaps >= (observed[near] - 1e-3)[:, None].astype(np.float32), axis=1)
        found[near] = (reached + own) / (flips + own)
        few = near[reached <= FEW]
        if own and len(few):
            found[few] = np.minimum(tail_probabilities(scores[i] - scores[others[few]]), (FEW + 1.0) / (flips + 1.0))
        p[i, others] = p[others, i] = found
    return p


def _signs(episodes: int, flips: int, seed: int) -> npt.NDArray[np.int8]:
    """Return random signs, (flips, episodes), as 0 or 1; every combination of signs, if these are fewer."""
    if 2**episodes <= flips:
        return ((np.arange(2**episodes)[:, None] >> np.arange(episodes)) & 1).astype(np.int8)
    return np.random.default_rng(seed).integers(0, 2, size=(flips, episodes), dtype=np.int8)


def tail_probabilities(differences: Floats) -> Floats:
    """Return the two-sided tail of each row's sum under random signs, by the saddlepoint approximation.

    It is corrected for the lattice of possible sums where all differences are multiples of one number.

    Args:
        differences: differences of pairs of runs, (pairs, episodes); each row's sum must not be 0.
    """
    sizes = np.abs(differences)
    observed = np.abs(differences.sum(axis=1))
    greatest = sizes.sum(axis=1)
    number = (sizes > _EXACT).sum(axis=1)
    steps = 2.0 * _units(sizes)
    point = _saddlepoints(sizes, observed)
    scaled = point[:, None] * sizes
    decay = np.exp(-2.0 * scaled)
    cumulant = (scaled + np.log1p(decay) - np.log(2.0)).sum(axis=1)  # log cosh
    curvature = np.sqrt((sizes**2 * 4.0 * decay / (1.0 + decay) ** 2).sum(axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        w = np.sqrt(np.maximum(2.0 * (point * observed - cumulant), 0.0))
        width = np.where(steps > 0.0, -np.expm1(-steps * point) / np.where(steps > 0.0, steps, 1.0), point)
        density = np.exp(-(w**2) / 2.0) / np.sqrt(2.0 * np.pi)
        one = ndtr(-w) + density * (1.0 / (width * curvature) - 1.0 / w)
    last = 0.5**number  # all signs as observed
    one = np.where(observed > greatest - _EXACT, last, np.maximum(one, last))
    both: Floats = np.clip(2.0 * one, 0.0, 1.0)
    return both


def holm(p: Sequence[float] | Floats) -> Floats:
    """Return p-values corrected for their number by Holm's step-down procedure (1979).

    Below a level, they claim a false difference anywhere in the family with at most that probability.
    """
    values = np.asarray(p, dtype=np.float64)
    order = np.argsort(values, kind="stable")
    scaled = values[order] * np.arange(len(values), 0, -1)
    corrected = np.empty_like(values)
    corrected[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return corrected


def difference_bounds(
    differences: Floats, strata: npt.NDArray[np.intp], confidence: float = CONFIDENCE
) -> tuple[float, float, float]:
    """Return the mean of a pair's differences and its interval, for episodes drawn anew within each stratum.

    Args:
        differences: difference in each episode, (episodes,), in [-1, 1].
        strata: as for `intervals.episode_moments`.
        confidence: nominal coverage.
    """
    moments = episode_moments(differences, strata)
    mean = float(moments.mean)
    if moments.freedom < 1:
        return mean, -1.0, 1.0
    # As if one more episode had shown the largest variance: equal runs are not known to be equal everywhere.
    share = (float(moments.variance) * moments.episodes * moments.freedom + 1.0) / (moments.freedom + 1.0)
    half = float(stdtrit(moments.freedom, 0.5 + confidence / 2.0)) * (share / moments.episodes) ** 0.5
    return mean, max(mean - half, -1.0), min(mean + half, 1.0)


def _saddlepoints(sizes: Floats, observed: Floats) -> Floats:
    """Return t > 0 with sum(sizes * tanh(t * sizes)) = observed in each row; anything where that has no solution."""
    squares = (sizes**2).sum(axis=1)
    greatest = sizes.sum(axis=1)
    low, high = np.zeros(len(sizes)), np.full(len(sizes), 1e4)
    point: Floats = observed / squares
    for _ in range(_NEWTON):
        slope = np.tanh(point[:, None] * sizes)
        excess = (sizes * slope).sum(axis=1) - observed
        low, high = np.where(excess < 0.0, point, low), np.where(excess < 0.0, high, point)
        curvature = (sizes**2 * (1.0 - slope**2)).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            following = point - excess / curvature
        inside = (following > low) & (following < high)
        point = np.where(inside, following, (low + high) / 2.0)
        if np.all((np.abs(excess) < 1e-9 * greatest) | (observed >= greatest - _EXACT)):
            break
    return point


def _units(sizes: Floats) -> Floats:
    """Return for each row the greatest multiple of 1/_PARTS that divides all its sizes; 0 if there is none."""
    numbers = np.rint(sizes * _PARTS)
    whole = (np.abs(sizes * _PARTS - numbers) < 1e-6).all(axis=1)
    units = np.zeros(len(sizes))
    units[whole] = np.gcd.reduce(numbers[whole].astype(np.int64), axis=1) / _PARTS
    return units


_PARTS = 720_720
"""Least common multiple of 1 to 16: the parts of 1 are whole numbers of it."""

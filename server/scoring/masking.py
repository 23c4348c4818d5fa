"""Masking of scores on a hidden split: rounded means, and what follows from them; amounts of noise: `disclosure.py`.

Two exact totals that differ by one episode reveal its score, and so does a rounded total whose threshold an attacker
has found, as the attacker controls all other episodes of its own runs. So each mean of a turn is rounded up or down to
the grid of `rounding_step` by a threshold of its own: up with a probability equal to its position between the two grid
points, except near 0 and 1, where rounding is certain (`upward_chance`). The shown mean is less than a step from the
exact mean. It is unbiased between the first and the last step, unless the order of metrics (see `_consistent`) lowers
it, and 0 and 1 are shown exactly. SECURITY.md bounds the information of one figure about an episode, whatever else is
known (`tests/scoring/figure_bits.py` computes it); the bounds of several figures add up.

Thresholds are derived from the split's ground truth, which is secret, and from the play digest: the actions and causes
of all episodes (`runs.storage.play_digest`). So the same play shows the same figures, no matter who plays it and in how
many pieces, and another play has independent thresholds. They must not depend on the scores: then two plays would show
equal figures exactly if they scored alike, and an attacker who knows the scores of one would learn those of the other.
Nor may they depend on less than the whole play: then an attacker could find a threshold with several plays that share
it. Anyone who has the split can derive the thresholds.

Means of groups have Gaussian noise with the deviation GROUP_NOISE, counted in turns: a figure reveals at most
log2(1 + v / GROUP_NOISE**2) / 2 bits of a score with variance v (the capacity of a Gaussian channel). Intervals,
differences of runs, means over seeds and languages, and gaps are computed from the shown means alone, with the largest
variance that such means allow, and so reveal nothing more. Paired tests, which decide ranks, use exact scores and
MIN_EPISODES further episodes of noise; their p-values are rounded up to one of P_CLASSES.
"""

import hmac
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from arramon_server.scoring.aggregate import ROWS, Interval
from arramon_server.scoring.disclosure import FLAT, GROUP_NOISE, MIN_EPISODES, STEPS, TEST_NOISE, rounding_step
from arramon_server.scoring.episode_scores import GATES, METRICS, PLACEMENT
from arramon_server.scoring.intervals import CONFIDENCE, Floats, Moments, mean_bounds

MASKED_METHOD = "from-masked-means"
"""Name of the method for intervals in receipts. A change of the method changes the name."""

P_CLASSES = (0.001, 0.01, 0.05, 1.0)
"""Values that p-values are rounded up to."""

_POSITION_DIGITS = 9
"""Decimals of a position between two grid points that are equal on all machines."""

_DIGITS = 4
"""Decimals to which means of shown figures are rounded, only for display."""

Rows = Mapping[str, Mapping[str, Interval]]


@dataclass(frozen=True, slots=True)
class Noise:
    """Deterministic random numbers, derived from a split's ground truth.

    Attributes:
        key: secret key, derived from the split's data.
    """

    key: bytes = b""

    def uniform(self, *names: str) -> float:
        """Return a uniform number in (0, 1), always the same for the same names."""
        digest = hmac.digest(self.key, "\0".join(names).encode(), "sha256")
        return (int.from_bytes(digest[:6]) + 0.5) / 2.0**48

    def normal(self, *names: str) -> float:
        """Return a standard normal number, always the same for the same names."""
        return _NORMAL.inv_cdf(self.uniform(*names))

    def test_scores(self, play_digest: str, metric: str) -> Floats:
        """Return a run's noise scores, (MIN_EPISODES,). The standard deviation of their sum is TEST_NOISE.

        Between two runs their differences are symmetric, as paired tests assume under their null hypothesis. Runs with
        the same play have equal ones.

        Args:
            play_digest: play digest of the run.
            metric: metric that is compared.
        """
        _check_play(play_digest)
        scale = TEST_NOISE / MIN_EPISODES**0.5
        scores: Floats = scale * np.array(
            [self.normal(play_digest, "test", metric, str(at)) for at in range(MIN_EPISODES)]
        )
        return scores


_NORMAL = NormalDist()


def masked_rows(turns: Floats, noise: Noise, play_digest: str) -> dict[str, dict[str, Interval]]:
    """Return the shown rows of a run's score table: turns rounded at random, and their means as total.

    Args:
        turns: scores of both turns of each episode, (episodes, 2, METRICS).
        noise: noise of the split.
        play_digest: play digest of the run.
    """
    _check_play(play_digest)
    episodes, step = len(turns), rounding_step(len(turns))
    exact = turns.mean(axis=0)
    found = []
    for turn, row in enumerate(ROWS[:2]):
        rounded = {
            metric: randomised_rounding(float(exact[turn, column]), step, noise.uniform(play_digest, row, metric))
            for column, metric in enumerate(METRICS)
        }
        found.append(_consistent(rounded))
    found.append({metric: _tidy((found[0][metric] + found[1][metric]) / 2.0) for metric in METRICS})
    return {
        row: {metric: mean_interval(value, episodes, shown_deviation(episodes), step) for metric, value in one.items()}
        for row, one in zip(ROWS, found, strict=True)
    }


def randomised_rounding(value: float, step: float, threshold: float) -> float:
    """Round a number to one of the two neighbouring grid points; a number on the grid stays the same.

    Args:
        value: number in [0, 1].
        step: step of the grid, which divides 1.
        threshold: number in (0, 1): the result is the upper grid point if `upward_chance` is above.
    """
    parts = round(1.0 / step)
    place = round(value * parts, _POSITION_DIGITS)  # equal on all machines, although sums differ in the last bits
    below = math.floor(place)
    return (below + (upward_chance(place, parts) > threshold)) / parts


def upward_chance(place: float, parts: int) -> float:
    """Return the probability that a number is rounded up: its position between two grid points, except near 0 and 1.

    Within FLAT steps of 0 or 1 a number is always rounded to 0 or 1, and the probability is steeper beyond: a run that
    stops at once in all episodes but one shows 0, whether or not it solved that one.

    Args:
        place: number in units of the grid's step, from 0 to `parts`.
        parts: number of steps from 0 to 1.
    """
    below = math.floor(place)
    low, high = FLAT * (below == 0), FLAT * (below == parts - 1)
    return min(max((place - below - low) / (1.0 - low - high), 0.0), 1.0)


def masked_group(
    scores: Floats, group: npt.NDArray[np.bool_], metrics: Sequence[str], noise: Noise, names: Sequence[str]
) -> dict[str, Interval]:
    """Return the shown means over a group of turns, by metric.

    Args:
        scores: scores of all turns, (episodes, 2, METRICS).
        group: the turns in the group, (episodes, 2).
        metrics: metrics to show.
        noise: noise of the split.
        names: digest of the play, and what names the group.
    """
    _check_play(names[0])
    turns, episodes = int(group.sum()), int(group.any(axis=1).sum())
    deviation = GROUP_NOISE / turns
    step = _step_above(deviation)
    noisy = {
        metric: float(scores[:, :, METRICS.index(metric)][group].mean()) + deviation * noise.normal(*names, metric)
        for metric in metrics
    }
    return {
        metric: mean_interval(_on_grid(value, step), episodes, math.hypot(deviation, step / 12.0**0.5), step)
        for metric, value in _levelled(noisy).items()
    }


def masked_share(share: float, episodes: int, noise: Noise, names: Sequence[str]) -> float:
    """Return the shown value of a share of the episodes.

    Args:
        share: exact share.
        episodes: number of the episodes.
        noise: noise of the split.
        names: names of the share, and the play digests.
    """
    return randomised_rounding(share, rounding_step(episodes), noise.uniform(*names))


def rounded_rows(rows: Rows, episodes: int) -> dict[str, dict[str, Interval]]:
    """Return the rounded rows of a table with exact scores, for a split whose thresholds are lost with its data."""
    step, deviation = rounding_step(episodes), shown_deviation(episodes)
    return {
        row: {
            metric: mean_interval(_on_grid(value.mean, step), episodes, deviation, step)
            for metric, value in values.items()
        }
        for row, values in rows.items()
    }


def mean_of_rows(tables: Sequence[Rows], episodes: int) -> dict[str, dict[str, Interval]]:
    """Return the means over the shown rows of several runs, which differ in seed or language.

    Args:
        tables: rows of the runs.
        episodes: number of episodes of each run; the least, if these differ.
    """
    step = rounding_step(episodes)

    def mean(row: str, metric: str) -> Interval:
        value = _tidy(sum(table[row][metric].mean for table in tables) / len(tables))
        return mean_interval(value, episodes, shown_deviation(episodes), step)

    return {row: {metric: mean(row, metric) for metric in tables[0][row]} for row in tables[0]}


def shown_deviation(episodes: int) -> float:
    """Return the largest standard deviation of a shown mean: half a step, midway between two grid points.

    It is used for means over turns and runs, too. Their thresholds are independent, but the order of metrics may lower
    all of them.
    """
    return rounding_step(episodes) / 2.0


def mean_interval(mean: float, episodes: int, deviation: float, step: float) -> Interval:
    """Return a shown mean with its interval, from the largest possible variance and the masking error.

    Args:
        mean: shown mean.
        episodes: number of episodes of the mean; below MIN_EPISODES the interval is [0, 1].
        deviation: standard deviation of the shown mean from the exact one.
        step: step to which the ends are rounded, outwards.
    """
    if episodes < MIN_EPISODES:
        return Interval(mean, 0.0, 1.0)
    value = np.array(mean)
    bounds = mean_bounds(Moments(value, value * (1.0 - value) / episodes, episodes, episodes - 1))
    hidden = _quantile(episodes) * deviation
    low = mean - math.hypot(mean - float(bounds.low), hidden)
    high = mean + math.hypot(float(bounds.high) - mean, hidden)
    return Interval(mean, max(_down(low, step), 0.0), min(_up(high, step), 1.0))


def shown_difference(one: float, other: float, episodes: int, deviation: float) -> Interval:
    """Return the difference of two shown means over the same episodes, with its interval.

    Its variance is the largest that scores with these means can have: as their squared differences are at most their
    differences, it is at most a + b - (a - b)**2, and the same for 1 - a and 1 - b.

    Args:
        one, other: shown means.
        episodes: number of the episodes; below MIN_EPISODES the interval is [-1, 1].
        deviation: standard deviation of the shown difference from the exact one.
    """
    found = _tidy(one - other)
    if episodes < MIN_EPISODES:
        return Interval(found, -1.0, 1.0)
    step = rounding_step(episodes)
    largest = max(min(one + other, 2.0 - one - other) - found**2, 0.0)
    variance = (largest * (episodes - 1) + 1.0) / episodes  # as if one more episode had shown all of it
    half = _quantile(episodes) * math.hypot((variance / episodes) ** 0.5, deviation)
    return Interval(found, max(_down(found - half, step), -1.0), min(_up(found + half, step), 1.0))


def p_value_class(p: float) -> float:
    """Return the least of P_CLASSES that is at least p."""
    return next((bound for bound in P_CLASSES if p <= bound), P_CLASSES[-1])


def digest_without(play_digest: str, voided: Collection[str]) -> str:
    """Return the play digest that seeds the rounding of a run's scores once some of its episodes are void.

    They are independent of the thresholds with all episodes: with equal thresholds, the figures before and after an
    episode is voided would differ by its score.

    Args:
        play_digest: play digest of the run, with all its episodes.
        voided: ids of those of its episodes that are void; with none it is `play_digest` itself.
    """
    return "\n".join([play_digest, "without", *sorted(voided)]) if voided and play_digest else play_digest


def two_digits(number: float) -> float:
    """Round a number, at least 0, to two significant digits."""
    return float(f"{number:.1e}")


def _consistent(values: dict[str, float]) -> dict[str, float]:
    """Lower rounded means to the order of exact ones: CTC grows with k, and gates and PTC only lower a score.

    Each stays within a step of its exact mean: if it is lowered to `more`, the exact mean of `less` is at most that of
    `more`, and so less than a step above the shown mean of `more`; and it is less than a step below, as before.
    """
    made = dict(values)
    for less, more in _ORDER:
        if less in made and more in made:
            made[less] = min(made[less], made[more])
    return made


def _levelled(values: dict[str, float]) -> dict[str, float]:
    """Return noisy means in the order of exact ones: two in the wrong order are replaced by their mean."""
    made = dict(values)
    for less, more in _ORDER:
        if less in made and more in made and made[less] > made[more]:
            made[less] = made[more] = (made[less] + made[more]) / 2.0
    return _consistent(made)


_ORDER = (
    ("CTC-5", "CTC-7"),
    ("CTC-3", "CTC-5"),
    ("PTC", "rPOD"),
    *((f"{name}@{gate}", more) for name in PLACEMENT for gate in GATES for more in (name, gate)),
    *((f"rPOD@{less}", f"rPOD@{more}") for less, more in (("CTC-5", "CTC-7"), ("CTC-3", "CTC-5"))),
    *((f"PTC@{gate}", f"rPOD@{gate}") for gate in GATES),
    *((f"PTC@{less}", f"PTC@{more}") for less, more in (("CTC-5", "CTC-7"), ("CTC-3", "CTC-5"))),
)
"""Pairs of metrics of which the first is never greater; the second one is not the first one of any later pair."""


def _step_above(deviation: float) -> float:
    return next((step for step in STEPS if step >= deviation), STEPS[-1])


def _on_grid(value: float, step: float) -> float:
    parts = round(1.0 / step)
    return min(max(round(value * parts), 0), parts) / parts


def _down(value: float, step: float) -> float:
    parts = round(1.0 / step)
    return math.floor(value * parts + 1e-9) / parts


def _up(value: float, step: float) -> float:
    parts = round(1.0 / step)
    return math.ceil(value * parts - 1e-9) / parts


def _tidy(value: float) -> float:
    return round(value, _DIGITS)


def _quantile(episodes: int) -> float:
    return float(stdtrit(episodes - 1, 0.5 + CONFIDENCE / 2.0))


def _check_play(play_digest: str) -> None:
    if not play_digest:
        raise ValueError("the digest of the play is missing: all runs of the split would share their thresholds")

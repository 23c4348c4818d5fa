"""The only figures that are shown of scores on a hidden split: means with noise, rounded, and what follows from them.

Two exact totals that differ by one episode give its score away, and so does a rounded one whose threshold an attacker
has found: the attacker controls all other episodes of its own runs. So Gaussian noise with the deviation NOISE, counted
in episodes, is added to each sum before it is rounded. It follows from the split's ground truth, which nobody outside
knows, and from the run's id: the same run always shows the same figures, two runs never share their noise, and who
has the split can derive it. What one figure tells of a score with variance v is at most log2(1 + v / NOISE**2) / 2 bits
(the capacity of a Gaussian channel), whatever else is known, and several figures tell at most the sum.

Intervals, differences of runs, means over seeds and languages, and gaps are computed from the shown means alone, with
the largest variance that such means allow, and so tell nothing further. Paired tests, which decide ranks, are of exact
scores with LEAST episodes of noise beside them; their p-values are shown as one of P_CLASSES.
"""

import hmac
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from server.scoring.aggregate import ROWS, Interval
from server.scoring.disclosure import GROUP_NOISE, LEAST, NOISE, STEPS, TEST_NOISE, step_of
from server.scoring.episode import GATES, METRICS, PLACEMENT
from server.scoring.intervals import CONFIDENCE, Floats, Moments, mean_bounds

MASKED_METHOD = "from-masked-means"
"""Name of the method of the intervals, as receipts state it. A change of the method changes the name."""

P_CLASSES = (0.001, 0.01, 0.05, 1.0)
"""Values that p-values are rounded up to."""

_DIGITS = 4
"""Decimals to which means of shown figures are rounded, for display alone."""

Rows = Mapping[str, Mapping[str, Interval]]


@dataclass(frozen=True, slots=True)
class Noise:
    """Noise that follows from a split's ground truth.

    Attributes:
        key: what the noise is derived from; unknown to all who do not have the split.
    """

    key: bytes = b""

    def normal(self, *names: str) -> float:
        """Return a number from the standard normal distribution, always the same one for the same names."""
        digest = hmac.digest(self.key, "\0".join(names).encode(), "sha256")
        return _NORMAL.inv_cdf((int.from_bytes(digest[:6]) + 0.5) / 2.0**48)

    def test_scores(self, run_id: str, metric: str) -> Floats:
        """Return scores of a run in LEAST made-up episodes, (LEAST,), whose sum has the standard deviation TEST_NOISE.

        Between two runs their differences are symmetric, as the paired tests suppose under their null hypothesis.
        """
        scale = TEST_NOISE / LEAST**0.5
        scores: Floats = scale * np.array([self.normal(run_id, "test", metric, str(at)) for at in range(LEAST)])
        return scores


_NORMAL = NormalDist()


def masked_rows(turns: Floats, noise: Noise, run_id: str) -> dict[str, dict[str, Interval]]:
    """Return the rows of a run's score table as they are shown: turns with noise, and their means as total.

    Args:
        turns: scores of both turns of each episode, (episodes, 2, METRICS).
        noise: of the split.
        run_id: id of the run.
    """
    episodes, step = len(turns), step_of(len(turns))
    exact = turns.mean(axis=0)
    found = []
    for turn, row in enumerate(ROWS[:2]):
        noisy = {
            metric: float(exact[turn, column]) + NOISE / episodes * noise.normal(run_id, row, metric)
            for column, metric in enumerate(METRICS)
        }
        found.append({metric: _on_grid(value, step) for metric, value in _consistent(noisy).items()})
    total = {metric: _tidy((found[0][metric] + found[1][metric]) / 2.0) for metric in METRICS}
    deviation = NOISE / episodes
    rows = {
        row: {metric: mean_interval(value, episodes, deviation, step) for metric, value in values.items()}
        for row, values in zip(ROWS[:2], found, strict=True)
    }
    rows[ROWS[2]] = {
        metric: mean_interval(value, episodes, total_deviation(episodes), step) for metric, value in total.items()
    }
    return rows


def masked_group(
    scores: Floats, group: npt.NDArray[np.bool_], metrics: Sequence[str], noise: Noise, names: Sequence[str]
) -> dict[str, Interval]:
    """Return the means over a group of turns as they are shown, by metric.

    Args:
        scores: of all turns, (episodes, 2, METRICS).
        group: the turns in the group, (episodes, 2).
        metrics: those that are shown.
        noise: of the split.
        names: id of the run, and what names the group.
    """
    turns, episodes = int(group.sum()), int(group.any(axis=1).sum())
    deviation = GROUP_NOISE / turns
    step = _step_above(deviation)
    noisy = {
        metric: float(scores[:, :, METRICS.index(metric)][group].mean()) + deviation * noise.normal(*names, metric)
        for metric in metrics
    }
    return {
        metric: mean_interval(_on_grid(value, step), episodes, deviation, step)
        for metric, value in _consistent(noisy).items()
    }


def masked_share(share: float, episodes: int, noise: Noise, names: Sequence[str]) -> float:
    """Return a share of the episodes as it is shown.

    Args:
        share: exact share.
        episodes: number of the episodes.
        noise: of the split.
        names: ids of the runs, and what names the share.
    """
    return _on_grid(share + NOISE / episodes * noise.normal(*names), step_of(episodes))


def rounded_rows(rows: Rows, episodes: int) -> dict[str, dict[str, Interval]]:
    """Return the rows of a table with exact scores, rounded, where the ground truth that noise follows from is gone."""
    step, deviation = step_of(episodes), NOISE / episodes
    return {
        row: {
            metric: mean_interval(_on_grid(value.mean, step), episodes, deviation, step)
            for metric, value in values.items()
        }
        for row, values in rows.items()
    }


def mean_of_rows(tables: Sequence[Rows], episodes: int) -> dict[str, dict[str, Interval]]:
    """Return the means of several runs' shown rows: those of several seeds, or languages.

    Args:
        tables: rows of the runs.
        episodes: number of episodes of each run; the least, if these differ.
    """
    step = step_of(episodes)

    def mean(row: str, metric: str) -> Interval:
        value = _tidy(sum(table[row][metric].mean for table in tables) / len(tables))
        deviation = total_deviation(episodes, len(tables)) * (1.0 if row == ROWS[2] else 2.0**0.5)
        return mean_interval(value, episodes, deviation, step)

    return {row: {metric: mean(row, metric) for metric in tables[0][row]} for row in tables[0]}


def total_deviation(episodes: int, runs: int = 1) -> float:
    """Return the standard deviation of the noise in the mean of both turns, over several runs."""
    return NOISE / episodes / math.sqrt(2.0 * runs)


def mean_interval(mean: float, episodes: int, deviation: float, step: float) -> Interval:
    """Return a shown mean with an interval that follows from it: that of the largest variance, and of the noise.

    Args:
        mean: shown mean.
        episodes: number of episodes that it is about; below LEAST the interval is [0, 1].
        deviation: standard deviation of the noise in the mean.
        step: step to which the mean was rounded, and to which the ends are, outwards.
    """
    if episodes < LEAST:
        return Interval(mean, 0.0, 1.0)
    value = np.array(mean)
    bounds = mean_bounds(Moments(value, value * (1.0 - value) / episodes, episodes, episodes - 1))
    noise = _quantile(episodes) * deviation
    low = mean - math.hypot(mean - float(bounds.low), noise) - step / 2.0
    high = mean + math.hypot(float(bounds.high) - mean, noise) + step / 2.0
    return Interval(mean, max(_down(low, step), 0.0), min(_up(high, step), 1.0))


def difference(one: float, other: float, episodes: int, deviation: float) -> Interval:
    """Return the difference of two shown means over the same episodes, with an interval that follows from them.

    Its variance is the largest that scores with these means can have: as their squared differences are at most their
    differences, it is at most a + b - (a - b)**2, and the same for 1 - a and 1 - b.

    Args:
        one, other: shown means.
        episodes: number of the episodes; below LEAST the interval is [-1, 1].
        deviation: standard deviation of the noise in the difference.
    """
    found = _tidy(one - other)
    if episodes < LEAST:
        return Interval(found, -1.0, 1.0)
    step = step_of(episodes)
    largest = max(min(one + other, 2.0 - one - other) - found**2, 0.0)
    variance = (largest * (episodes - 1) + 1.0) / episodes  # as if one more episode had shown all of it
    half = _quantile(episodes) * math.hypot((variance / episodes) ** 0.5, deviation) + step
    return Interval(found, max(_down(found - half, step), -1.0), min(_up(found + half, step), 1.0))


def p_class(p: float) -> float:
    """Return the least of P_CLASSES that is at least p."""
    return next((bound for bound in P_CLASSES if p <= bound), P_CLASSES[-1])


def coarse(number: float) -> float:
    """Return a number, at least 0, rounded to two significant digits."""
    return float(f"{number:.1e}")


def _consistent(values: dict[str, float]) -> dict[str, float]:
    """Return noisy means in the order that exact ones have: CTC grows with k, a gate and PTC only lower."""
    made = dict(values)
    for less, more in _ORDER:
        if less in made and more in made and made[less] > made[more]:
            made[less] = made[more] = (made[less] + made[more]) / 2.0
    for less, more in _ORDER:  # a last pass, for chains
        if less in made and more in made:
            made[less] = min(made[less], made[more])
    return made


_ORDER = (
    ("CTC-3", "CTC-5"),
    ("CTC-5", "CTC-7"),
    ("CTC-3", "CTC-5"),
    ("PTC", "rPOD"),
    *((f"{name}@{gate}", name) for gate in GATES for name in PLACEMENT),
    *((f"PTC@{gate}", f"rPOD@{gate}") for gate in GATES),
    *(
        (f"{name}@{less}", f"{name}@{more}")
        for name in PLACEMENT
        for less, more in (("CTC-5", "CTC-7"), ("CTC-3", "CTC-5"))
    ),
)
"""Pairs of metrics of which the first is never the greater."""


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

"""Changes of agents' scores between two epochs of a hidden split, which are drawn from the same distribution.

They are computed from the shown means of each epoch alone, so that a change reveals nothing more about single episodes.
Its interval assumes the largest variance that these means allow, with other episodes drawn in both epochs. All agents
played the same episodes, so that a set that is easier by chance changes all scores alike: the change relative to the
other agents cancels that out.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from scipy.special import ndtri

from arramon_server.scoring.aggregate import Interval
from arramon_server.scoring.disclosure import MIN_EPISODES, rounding_step
from arramon_server.scoring.intervals import CONFIDENCE
from arramon_server.scoring.masking import shown_deviation


@dataclass(frozen=True, slots=True)
class EpochScores:
    """Shown scores of several agents on one epoch.

    Attributes:
        means: shown mean of each agent over both turns.
        runs: number of runs of each mean.
        episodes: number of the epoch's episodes that are not void.
    """

    means: Sequence[float]
    runs: Sequence[int]
    episodes: int


@dataclass(frozen=True, slots=True)
class ScoreChanges:
    """Changes of several agents: the newer mean minus the older one, with 95% intervals within [-1, 1].

    Attributes:
        of_each: change of each agent.
        against_others: change of each agent minus the mean change of all others; None with one agent.
        mean: mean change over the agents.
    """

    of_each: tuple[Interval, ...]
    against_others: tuple[Interval, ...] | None
    mean: Interval


@dataclass(frozen=True, slots=True)
class _MaskedFigure:
    """A mean or difference of means in one epoch, with its largest variance per episode and its rounding variance."""

    value: float
    variance: float
    rounding: float


def score_changes(older: EpochScores, newer: EpochScores) -> ScoreChanges:
    """Return the changes of agents that played both epochs.

    Args:
        older, newer: scores of the same agents, in one order; at least one agent.
    """
    agents = range(len(older.means))
    each = tuple(_change(older, newer, *(_own(one, at) for one in (older, newer))) for at in agents)
    mean = _change(older, newer, *(_mean(one) for one in (older, newer)))
    if len(agents) < 2:
        return ScoreChanges(each, None, mean)
    relative = (_change(older, newer, *(_relative_to_others(one, at) for one in (older, newer))) for at in agents)
    return ScoreChanges(each, tuple(relative), mean)


def _own(scored: EpochScores, at: int) -> _MaskedFigure:
    mean = scored.means[at]
    return _MaskedFigure(mean, mean * (1.0 - mean), shown_deviation(scored.episodes) ** 2)


def _mean(scored: EpochScores) -> _MaskedFigure:
    agents = len(scored.means)
    mean = sum(scored.means) / agents
    return _MaskedFigure(mean, mean * (1.0 - mean), shown_deviation(scored.episodes) ** 2)


def _relative_to_others(scored: EpochScores, at: int) -> _MaskedFigure:
    """Return an agent's mean minus the mean of all others, see `masking.shown_difference` for the variance."""
    means, runs = ([*whole[:at], *whole[at + 1 :]] for whole in (scored.means, scored.runs))
    rest = EpochScores(means, runs, scored.episodes)
    own, others = _own(scored, at), _mean(rest)
    value = own.value - others.value
    largest = min(own.value + others.value, 2.0 - own.value - others.value) - value**2
    return _MaskedFigure(value, max(largest, 0.0), own.rounding + others.rounding)


def _change(older: EpochScores, newer: EpochScores, before: _MaskedFigure, after: _MaskedFigure) -> Interval:
    mean = round(after.value - before.value, 4)
    if min(older.episodes, newer.episodes) < MIN_EPISODES:
        return Interval(mean, -1.0, 1.0)
    step = max(rounding_step(older.episodes), rounding_step(newer.episodes))
    variance = sum(
        (one.variance * (scored.episodes - 1) + 1.0) / scored.episodes**2 + one.rounding
        for scored, one in ((older, before), (newer, after))
    )
    half = _QUANTILE * variance**0.5
    parts = round(1.0 / step)
    low, high = math.floor((mean - half) * parts) / parts, math.ceil((mean + half) * parts) / parts
    return Interval(mean, max(low, -1.0), min(high, 1.0))


_QUANTILE = float(ndtri(0.5 + CONFIDENCE / 2.0))

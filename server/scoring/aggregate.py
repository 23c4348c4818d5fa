"""Aggregation of episode scores into a table of means with confidence intervals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_server.scoring.episode_scores import METRICS, EpisodeScores
from arramon_server.scoring.intervals import (
    CONFIDENCE,
    Bounds,
    Floats,
    episode_moments,
    mean_bounds,
    section_bounds,
    section_spread,
)

ROWS = ("turn 1", "turn 2", "total")

METHOD = "wilson-within-sections"
"""Name of the method for intervals in receipts. A change of the method changes the name."""

MIN_SECTION = 10
"""Minimum episodes per section to compute differences between sections: fewer would reveal single episodes."""


@dataclass(frozen=True, slots=True)
class SectionSpread:
    """Differences between the sections of a split.

    Attributes:
        deviation: standard deviation between the sections' true means, as estimated; at least 0.
        low, high: interval for the mean over other sections of the same kind, which were not played.
    """

    deviation: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Interval:
    """A mean and its confidence interval.

    Attributes:
        mean: mean over the episodes.
        low: lower end of the interval; never above the mean.
        high: upper end of the interval; never below the mean.
        sections: differences between sections; None with one section, or with less than MIN_SECTION episodes in one.
    """

    mean: float
    low: float
    high: float
    sections: SectionSpread | None = None


@dataclass(frozen=True, slots=True)
class ScoreTable:
    """The score table of a run.

    Attributes:
        rows: row name of ROWS -> metric name of METRICS -> value.
        episodes: number of episodes, the denominator of the means.
    """

    rows: Mapping[str, Mapping[str, Interval]]
    episodes: int


def aggregate(episodes: Sequence[EpisodeScores], *, confidence: float = CONFIDENCE) -> ScoreTable:
    """Return means over all episodes, per turn and over both turns, with their intervals.

    An interval is for the mean if other episodes had been drawn in each of these sections; the interval in
    `SectionSpread` is for other sections. The result does not depend on the order of `episodes`.

    Args:
        episodes: scores of every episode of the run, including those that were not played.
        confidence: nominal coverage of the intervals.

    Raises:
        ValueError: if there are no episodes.
    """
    if not episodes:
        raise ValueError("no episodes to aggregate; expected at least one")
    ordered = sorted(episodes, key=lambda episode: episode.episode_id)
    turns = np.array([[[turn[name] for name in METRICS] for turn in episode.turns] for episode in ordered])
    _, sections = np.unique([episode.section for episode in ordered], return_inverse=True)
    return ScoreTable(table_rows(with_total(turns), sections, confidence), len(ordered))


def with_total(turns: Floats) -> Floats:
    """Return the scores of both turns and of their mean, (episodes, ROWS, metrics), from (episodes, 2, metrics)."""
    return np.concatenate([turns, turns.mean(axis=1, keepdims=True)], axis=1)


def table_rows(
    values: Floats, strata: npt.NDArray[np.intp], confidence: float = CONFIDENCE, *, are_sections: bool = True
) -> dict[str, dict[str, Interval]]:
    """Return the rows of a score table.

    Args:
        values: scores of each episode, (episodes, ROWS, METRICS).
        strata: number of each episode's stratum from 0, (episodes,).
        confidence: nominal coverage of the intervals.
        are_sections: whether the strata are the sections; otherwise differences between them are left out.
    """
    bounds = mean_bounds(episode_moments(values, strata), confidence)
    spread, others = None, None
    if are_sections and np.bincount(strata).min() >= MIN_SECTION:
        spread, others = section_spread(values, strata), section_bounds(values, strata, confidence)

    def interval(row: int, metric: int) -> Interval:
        place = row, metric
        between = None
        if spread is not None and others is not None:
            between = SectionSpread(float(spread[place]), float(others.low[place]), float(others.high[place]))
        return Interval(*_ends(bounds, place), between)

    return {row: {metric: interval(r, m) for m, metric in enumerate(METRICS)} for r, row in enumerate(ROWS)}


def _ends(bounds: Bounds, place: tuple[int, int]) -> tuple[float, float, float]:
    return float(bounds.mean[place]), float(bounds.low[place]), float(bounds.high[place])

"""Language gaps: differences between the scores of one agent's runs in two languages on the same episodes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from rich.table import Table

from arramon.v1 import evaluation_pb2
from arramon_client.results import COLUMNS, table_of_metrics

TOTAL, TURNS = "total", ("turn 1", "turn 2")

MIN_EPISODES = 10
"""Minimum number of episodes for which an interval is computed."""

INTERVALS = "below a difference: its 95% interval, paired by episode"
"""Caption of a table of gaps with an interval."""

NO_INTERVALS = f"no intervals: they need the scores of {MIN_EPISODES} single episodes"
"""Caption of a table of gaps without any."""

_Z = 1.959964
"""Quantile of the normal distribution for 95% intervals."""


@dataclass(frozen=True)
class Gap:
    """The difference between the scores in two languages in one metric.

    Attributes:
        metric: the metric, over both turns.
        first, second: codes of the languages.
        difference: mean in the first language minus mean in the second.
        low, high: ends of its 95% interval, paired by episode; None if the server does not report scores of single
            episodes, or there are fewer than `MIN_EPISODES`.
    """

    metric: str
    first: str
    second: str
    difference: float
    low: float | None = None
    high: float | None = None


def gaps(first: evaluation_pb2.Report, second: evaluation_pb2.Report) -> list[Gap]:
    """Return the differences in those metrics of the score table that both reports have."""
    found = []
    before, after = _totals(first), _totals(second)
    for _, metric in COLUMNS:
        if metric in before and metric in after:
            low, high = _interval(first, second, metric)
            names = (first.run.language, second.run.language)
            found.append(Gap(metric, *names, before[metric] - after[metric], low, high))
    return found


def gap_table(reports: Sequence[evaluation_pb2.Report]) -> Table:
    """Return the table of gaps between the first report and each of the others."""
    run = reports[0].run
    found = [gaps(reports[0], other) for other in reports[1:]]
    has_interval = any(gap.low is not None for its in found for gap in its)
    table = table_of_metrics(
        f"{run.agent} on {run.split}: gap between languages, both turns",
        INTERVALS if has_interval else NO_INTERVALS,
    )
    for other, its in zip(reports[1:], found, strict=True):
        by_metric = {gap.metric: gap for gap in its}
        cells = [_cell(by_metric.get(metric)) for _, metric in COLUMNS]
        table.add_row(f"{run.language} minus {other.run.language} ", *cells)
    return table


def _cell(gap: Gap | None) -> str:
    if gap is None:
        return "-"
    interval = "" if gap.low is None else f"\n{gap.low:+.2f}..{gap.high:+.2f}"
    return f"{gap.difference:+.3f}{interval}"


def _totals(report: evaluation_pb2.Report) -> dict[str, float]:
    return {score.metric: score.mean for row in report.rows if row.name == TOTAL for score in row.scores}


def _interval(
    first: evaluation_pb2.Report, second: evaluation_pb2.Report, metric: str
) -> tuple[float | None, float | None]:
    before, after = _by_episode(first, metric), _by_episode(second, metric)
    differences = [value - after[episode_id] for episode_id, value in before.items() if episode_id in after]
    number = len(differences)
    if number < MIN_EPISODES or before.keys() != after.keys():
        return None, None
    mean = math.fsum(differences) / number
    deviation = math.sqrt(math.fsum((each - mean) ** 2 for each in differences) / (number - 1))
    margin = _student(number - 1) * deviation / math.sqrt(number)
    return max(mean - margin, -1.0), min(mean + margin, 1.0)


def _by_episode(report: evaluation_pb2.Report, metric: str) -> dict[str, float]:
    """Return each episode's mean over its two turns, without episodes that lack the metric."""
    found = {}
    for episode in report.episodes:
        values = [s.mean for row in episode.turns if row.name in TURNS for s in row.scores if s.metric == metric]
        if len(values) == len(TURNS):
            found[episode.episode_id] = sum(values) / len(TURNS)
    return found


def _student(freedom: int) -> float:
    """Return the quantile of Student's t-distribution for 95% intervals (Abramowitz and Stegun 26.7.5)."""
    z = _Z
    return z + (z**3 + z) / (4 * freedom) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)

"""Template variables of the breakdown on a run's page: scores by what the turns ask for."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from arramon_server.runs.results.breakdown import Breakdown, BreakdownLine
from arramon_server.runs.results.turn_groups import TurnGroup
from arramon_server.scoring.aggregate import Interval
from arramon_server.scoring.breakdown import SHOWN
from arramon_server.scoring.disclosure import MIN_EPISODES
from arramon_server.web.page_texts import PageTexts

PLOTTED = ("CTC-3", "PTC", "PTC@CTC-3")
"""Metrics in the plot: one for the navigation, one for the assembly, one for both."""

PHASES = {"nDTW": "navigation", "CTC-3": "navigation", "rPOD": "assembly", "PTC": "assembly", "PTC@CTC-3": "both"}


@dataclass(frozen=True, slots=True)
class BreakdownRow:
    """A group of turns with its scores.

    Attributes:
        name: what the turns have in common.
        turns: number of turns, formatted.
        plotted: scores by the metrics in PLOTTED.
        scores: scores by the metrics in SHOWN.
    """

    name: str
    turns: str
    plotted: Sequence[Interval]
    scores: Sequence[Interval]


@dataclass(frozen=True, slots=True)
class BreakdownPart:
    """Template variables of the breakdown.

    Attributes:
        aspects: heading and rows of each aspect.
        columns: heading of each score: its name and its phase.
        legend: labels of the scores in the plot.
        remarks: notes for the reader, such as on rounding.
    """

    aspects: Sequence[tuple[str, Sequence[BreakdownRow]]]
    columns: Sequence[tuple[str, str]]
    legend: Sequence[str]
    remarks: Sequence[str]


def breakdown_part(t: PageTexts, breakdown: Breakdown) -> BreakdownPart:
    """Return the breakdown of a run."""
    aspects = [
        (t(f"aspects.{aspect}"), [_row(t, line) for line in lines])
        for aspect, lines in groupby(breakdown.lines, lambda line: line.group.aspect)
    ]
    columns = [(metric.partition("@")[0], t(f"report.{PHASES[metric]}")) for metric in SHOWN]
    legend = [f"{t(f'report.{PHASES[metric]}')}: {metric.partition('@')[0]}" for metric in PLOTTED]
    return BreakdownPart(aspects, columns, legend, list(_remarks(t, breakdown)))


def _remarks(t: PageTexts, breakdown: Breakdown) -> list[str]:
    remarks = []
    if breakdown.rounded:
        remarks.append(t("report.hidden", least=t.whole(MIN_EPISODES)) if breakdown.lines else t("report.few"))
    if breakdown.withheld and breakdown.lines:
        remarks.append(t("report.withheld", number=t.whole(breakdown.withheld)))
    if not breakdown.knows_demands:
        remarks.append(t("report.unread"))
    return remarks


def _row(t: PageTexts, line: BreakdownLine) -> BreakdownRow:
    scores = line.found.scores
    return BreakdownRow(
        _name(t, line.group),
        t.whole(line.found.turns),
        [scores[metric] for metric in PLOTTED],
        [scores[metric] for metric in SHOWN],
    )


def _name(t: PageTexts, group: TurnGroup) -> str:
    if group.name:
        kind = "relation" if group.aspect == "placement" else group.aspect
        return t.named("groups", f"{kind}.{group.name}")
    if group.high is None:
        return t("report.or_more", low=t.whole(group.low))
    if group.low == group.high:
        return t.whole(group.low)
    return t("format.interval", low=t.whole(group.low), high=t.whole(group.high))

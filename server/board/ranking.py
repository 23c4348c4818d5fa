"""Ranking of standings by a metric, with ties."""

from collections.abc import Iterable
from dataclasses import replace

from server.board.standings import TOTAL, Standing
from server.scoring.aggregate import Interval

_TIE_BREAKERS = ("PTC@CTC-3", "rPOD@CTC-3", "CTC-3", "nDTW")
"""Metrics that order standings with equal means, in this sequence."""


def ranked(standings: Iterable[Standing], metric: str) -> list[Standing]:
    """Return the standings sorted, the best first, with their ranks; those that are not ranked come last.

    They are sorted by the metric's mean in the row "total", then by PTC, rPOD, CTC-3 and nDTW, then by time of
    publication, the earliest first. Ranks follow from intervals: the best standing leads a group, and each next one
    belongs to it as long as its interval overlaps with the leader's (its upper end is not below the leader's lower
    end). The first that does not leads the next group. A group shares one rank: 1 + the number of standings before it.

    Args:
        standings: standings in any order.
        metric: metric to rank by, one of COLUMNS.
    """
    ordered = sorted(standings, key=lambda standing: _key(standing, metric))
    able = [standing for standing in ordered if standing.is_ranked]
    apart = [replace(standing, rank=0, tied=False) for standing in ordered if not standing.is_ranked]
    groups: list[list[Standing]] = []
    for standing in able:
        if groups and _interval(standing, metric).high >= _interval(groups[-1][0], metric).low:
            groups[-1].append(standing)
        else:
            groups.append([standing])
    placed: list[Standing] = []
    for group in groups:
        rank = len(placed) + 1
        placed += [replace(standing, rank=rank, tied=len(group) > 1) for standing in group]
    return placed + apart


def _key(standing: Standing, metric: str) -> tuple[object, ...]:
    means = [-standing.rows[TOTAL][name].mean for name in (metric, *_TIE_BREAKERS)]
    return (*means, max(entry.published_at for entry in standing.entries), standing.entries[0].run.run_id)


def _interval(standing: Standing, metric: str) -> Interval:
    return standing.rows[TOTAL][metric]

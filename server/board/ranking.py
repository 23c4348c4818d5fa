"""Ranking of standings by a metric, from paired tests of all pairs."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace

from arramon_server.board.comparisons import ComparisonFamily
from arramon_server.board.standings import TOTAL, Standing

_TIE_BREAKERS = ("PTC@CTC-3", "rPOD@CTC-3", "CTC-3", "nDTW")
"""Metrics that break ties between equal means, in this order."""


def ranked(standings: Iterable[Standing], metric: str, family: ComparisonFamily) -> list[Standing]:
    """Return the standings with their ranks, in order of rank; unranked standings come last.

    A rank is one more than the number of significantly better standings, so standings of one rank do not differ
    significantly. Within a rank they are sorted by the metric's mean in the row "total", then by PTC, rPOD, CTC-3 and
    nDTW, then by time of publication, the earliest first.

    Args:
        standings: standings in any order.
        metric: metric to rank by, one of COLUMNS.
        family: tests of all pairs of ranked standings by this metric.
    """
    ordered = sorted(standings, key=lambda standing: _key(standing, metric))
    comparable = [standing for standing in ordered if standing.is_ranked]
    ranges = [family.rank_range(standing) for standing in comparable]
    first_ranks = Counter(first for first, _ in ranges)
    placed = [
        replace(standing, rank=first, last_rank=last, tied=first_ranks[first] > 1)
        for standing, (first, last) in zip(comparable, ranges, strict=True)
    ]
    unranked = [replace(standing, rank=0, last_rank=0, tied=False) for standing in ordered if not standing.is_ranked]
    return sorted(placed, key=lambda standing: standing.rank) + unranked


def _key(standing: Standing, metric: str) -> tuple[object, ...]:
    means = [-standing.rows[TOTAL][name].mean for name in (metric, *_TIE_BREAKERS)]
    return (*means, max(entry.published_at for entry in standing.entries), standing.entries[0].run.run_id)

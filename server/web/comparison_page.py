"""Template variables of the page that compares a run with all others of its standings."""

from collections.abc import Mapping
from typing import Any

from arramon_server.board.board import Board, RunComparisons
from arramon_server.board.standings import BOTH, HEADLINE, Standing
from arramon_server.errors import Conflict, NotFound
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.standings_query import METRICS, StandingsQuery

_SHOWN = {1: "against.better", 0: "against.same", -1: "against.worse"}
"""Outcome of a comparison -> key of its text."""


class ComparisonPage:
    """Builds the variables of the page.

    Args:
        board: the leaderboard.
    """

    def __init__(self, board: Board) -> None:
        self._board = board

    def context(self, t: PageTexts, run_id: str, query: Mapping[str, str]) -> dict[str, Any]:
        """Return the variables of the template.

        Args:
            t: texts of the page's language.
            run_id: id of a published run.
            query: query of the address: "language", of the instructions or BOTH, and "sort", a metric of METRICS.

        Raises:
            NotFound: if the run is not published, or the query has an unknown value.
        """
        entry = self._board.entry(run_id)
        run = entry.run
        language = query.get("language", run.language)
        sort = query.get("sort", HEADLINE.partition("@")[0].lower())
        if sort not in METRICS or language not in (run.language, BOTH):
            raise NotFound("there is no such comparison")
        return {
            "entry": entry,
            "language": language,
            "sort": sort,
            "heading": METRICS[sort].partition("@")[0],
            "against": self._against(run_id, language, METRICS[sort]),
            "shown": _SHOWN,
            "languages_choices": [(code, t.named("languages", code)) for code in (run.language, BOTH)],
            "metric_choices": [(name, metric.partition("@")[0]) for name, metric in METRICS.items()],
            "back": f"/{t.language}/{StandingsQuery(run.split, language, sort=sort).link()}",
            "link": _link,
        }

    def _against(self, run_id: str, language: str, metric: str) -> RunComparisons | None:
        """Return the comparisons; None if the run is not ranked in these standings, or not in them."""
        try:
            return self._board.compare_with_all(run_id, language, metric)
        except (Conflict, NotFound):
            return None


def _link(standing: Standing, language: str, sort: str) -> str:
    """Return the address of another standing's comparisons, without the page's language."""
    return f"/runs/{standing.entries[0].run.run_id}/against?language={language}&sort={sort}"

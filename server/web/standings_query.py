"""Filters and sort order of the standings page, as encoded in the query of its address."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from urllib.parse import urlencode

from arramon_server.board.standings import BOTH, COLUMNS, HEADLINE, PRIVILEGED, TOTAL, Mark, Standing
from arramon_server.errors import NotFound, quoted
from arramon_server.web.cost_part import COSTS

TURNS = {"total": TOTAL, "1": "turn 1", "2": "turn 2"}
"""Turns in addresses -> row of a score table."""

ALL = "all"

SENSORS = (ALL, "plain", "segmentation", "privileged")
"""Filters by sensors. "plain": at most RGB and depth. "segmentation": segmentation, but no privileged sensors.
"privileged": sensors that give information which no camera shows."""

COVERAGES = (ALL, "whole", "partial")

METRICS = {metric.partition("@")[0].lower(): metric for metric in COLUMNS}
"""Name of a metric in addresses -> the metric."""

GAP = "gap"
"""Column with the gap between languages, in lists of all languages combined."""

OTHER_COLUMNS = ("agent", "published", GAP)
"""Sort columns that are no metrics. The standings are then ranked by the headline metric."""

ASCENDING, DESCENDING = "asc", "desc"

_UPWARDS = ("agent", GAP)
"""Columns whose first sort order is ascending."""

_LEAST = re.compile(r"(0?\.[0-9]{1,6}|[01](\.0*)?)?", re.ASCII)

_CHOICES: Mapping[str, tuple[str, ...]] = {
    "turns": tuple(TURNS),
    "sensors": SENSORS,
    "coverage": COVERAGES,
    "sort": (*METRICS, *OTHER_COLUMNS),
    "order": (ASCENDING, DESCENDING),
    "cost": COSTS,
}


@dataclass(frozen=True, slots=True)
class StandingsQuery:
    """The list of standings that a reader requested: split, language, filters and sort order.

    Attributes:
        split: name of the split.
        language: language of the instructions, or BOTH.
        turns: one of TURNS.
        sensors: one of SENSORS.
        coverage: one of COVERAGES.
        sort: one of METRICS or OTHER_COLUMNS.
        order: ASCENDING or DESCENDING; `first_order` of the column if the address has none.
        page: page number, from 1.
        least: minimum score of standings sorted by the gap between languages, as a decimal number; empty for none.
        cost: cost against which scores are plotted, one of COSTS.
    """

    split: str
    language: str
    turns: str = "total"
    sensors: str = ALL
    coverage: str = ALL
    sort: str = HEADLINE.partition("@")[0].lower()
    order: str = DESCENDING
    page: int = 1
    least: str = ""
    cost: str = COSTS[0]

    @property
    def metric(self) -> str:
        """Metric that ranks the standings."""
        return METRICS.get(self.sort, HEADLINE)

    def link(self, **changes: object) -> str:
        """Return the query with some fields changed, without fields that have their defaults."""
        changed = {"page": 1, **changes}
        other = replace(self, **changed)  # type: ignore[arg-type]
        defaults = StandingsQuery(other.split, other.language, order=first_order(other.sort))
        named = {field.name: getattr(other, field.name) for field in fields(other)}
        shown = {k: v for k, v in named.items() if k in ("split", "language") or v != getattr(defaults, k)}
        return "?" + urlencode(shown)

    def sorting(self, column: str) -> str:
        """Return the query that sorts by a column; in reverse order if it is the current column."""
        reversed_order = ASCENDING if self.order == DESCENDING else DESCENDING
        return self.link(sort=column, order=reversed_order if column == self.sort else first_order(column))

    @property
    def is_reversed(self) -> bool:
        """Whether the order is not the column's first order."""
        return self.order != first_order(self.sort)

    def fits(self, standing: Standing) -> bool:
        """Return whether a standing passes the filters."""
        kinds = {
            ALL: True,
            "plain": set(standing.sensors) <= {"rgb", "depth"},
            "segmentation": "segmentation" in standing.sensors and not PRIVILEGED.intersection(standing.sensors),
            "privileged": bool(PRIVILEGED.intersection(standing.sensors)),
        }
        partial = Mark.PARTIAL in standing.marks
        if (
            self.least
            and self.sort == GAP
            and standing.rows
            and standing.rows[TOTAL][self.metric].mean < float(self.least)
        ):
            return False
        return kinds[self.sensors] and self.coverage in (ALL, "partial" if partial else "whole")

    def sorted(self, standings: list[Standing]) -> list[Standing]:
        """Return standings in the requested order; if sorted by a metric, unranked ones come last."""
        down = self.order == DESCENDING
        if self.sort == "published":
            return sorted(standings, key=lambda one: max(e.published_at for e in one.entries), reverse=down)
        if self.sort == "agent":
            return sorted(standings, key=lambda one: (one.agent.casefold(), one.participant.casefold()), reverse=down)
        if self.sort == GAP:
            known = sorted((one for one in standings if one.gap), key=lambda one: one.gap.mean if one.gap else 0.0)
            return [*(known[::-1] if down else known), *(one for one in standings if not one.gap)]
        if not all(one.rows for one in standings):  # frozen
            return standings
        ordered = standings if down else standings[::-1]
        if TURNS[self.turns] != TOTAL:
            row = TURNS[self.turns]
            ordered = sorted(ordered, key=lambda one: one.rows[row][self.metric].mean, reverse=down)
        return sorted(ordered, key=lambda one: not one.is_ranked)


def first_order(column: str) -> str:
    """Return a column's first sort order: smallest gap, first name, or best score first."""
    return ASCENDING if column in _UPWARDS else DESCENDING


def read_query(
    query: Mapping[str, str], languages: Mapping[str, tuple[str, ...]], defaults: StandingsQuery
) -> StandingsQuery:
    """Parse the query of an address.

    Args:
        query: query of the address.
        languages: languages of each split, by name.
        defaults: values of fields that the address lacks.

    Raises:
        NotFound: if a field has a value that does not exist.
    """
    chosen = {name: query[name] for name in ("split", "language", *_CHOICES) if name in query}
    split = chosen.get("split", defaults.split)
    if split not in languages:
        raise NotFound(f"there is no split {quoted(split)}")
    known_languages = {language for codes in languages.values() for language in codes}
    if languages[split] and chosen.setdefault("language", defaults.language) in known_languages - set(languages[split]):
        chosen["language"] = languages[split][0]  # The new split lacks the language of the one shown before.
    choices = {**_CHOICES, "language": (*known_languages, BOTH)}
    for name, value in chosen.items():
        if name != "split" and value not in choices[name]:
            raise NotFound(f"there is no {name} {value!r}")
    chosen.setdefault("order", first_order(chosen.get("sort", defaults.sort)))
    page = query.get("page", "1")
    if not (page.isascii() and page.isdecimal() and int(page[:6]) > 0):
        raise NotFound(f"there is no page {page!r}")
    least = query.get("least", "")
    if not _LEAST.fullmatch(least):
        raise NotFound(f"there is no score {quoted(least)}")
    return replace(defaults, **chosen, page=int(page[:6]), least=least)

"""Template variables of the plot and table of scores against costs on the standings page."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from arramon_server.board.standings import Standing
from arramon_server.web.curves import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, Tick
from arramon_server.web.page_texts import PageTexts

COSTS = ("thinking", "parameters", "tokens", "price")
"""Names of costs in addresses: the server measures the first, participants declare the others."""

_ZERO = 36
"""Width of the strip for a cost of 0, which a logarithmic axis cannot show, in the picture's units."""

_ENDS = ("mean", "high", "low")

_FINE = 2
"""Maximum number of decades for which the axis also has ticks at 2 and 5 times each power of ten."""


@dataclass(frozen=True, slots=True)
class CostPoint:
    """A standing in the plot, in the picture's units.

    Attributes:
        rank: rank as in the standings, such as "2="; "–" if it has none.
        name: the agent's name.
        x, y: position.
        top, bottom: ends of the score's interval.
    """

    rank: str
    name: str
    x: float
    y: float
    top: float
    bottom: float


@dataclass(frozen=True, slots=True)
class CostPart:
    """Template variables of the plot and the table.

    Attributes:
        chosen: cost on the horizontal axis, one of COSTS.
        x_ticks, y_ticks: ticks of the horizontal and the vertical axis, with their labels.
        points: standings whose cost is known.
        rows: standing, its rank as in the plot, and each of COSTS as text.
    """

    chosen: str
    x_ticks: Sequence[tuple[float, str]]
    y_ticks: Sequence[Tick]
    points: Sequence[CostPoint]
    rows: Sequence[tuple[Standing, str, Sequence[str]]]


def cost_part(t: PageTexts, standings: Sequence[Standing], row: str, metric: str, chosen: str) -> CostPart | None:
    """Return the plot and the table; None if no cost of any standing is known.

    Args:
        t: texts of the page's language.
        standings: standings on the page.
        row: row of the score table.
        metric: metric of the plotted scores.
        chosen: cost on the horizontal axis, one of COSTS.
    """
    known = [(one, [_value(one, cost) for cost in COSTS]) for one in standings]
    known = [(one, values) for one, values in known if any(value is not None for value in values)]
    if not known:
        return None
    place = COSTS.index(chosen)
    drawn = [(one, values[place]) for one, values in known]
    scale = _Scale([value for _, value in drawn if value is not None])
    points = [
        CostPoint(
            _rank(t, one),
            one.agent,
            scale.place(cost),
            *(_score_y(getattr(one.rows[row][metric], end)) for end in _ENDS),
        )
        for one, cost in drawn
        if cost is not None
    ]
    x_ticks = [(scale.place(value), t.amount(value)) for value in scale.ticks()]
    y_ticks = [Tick(_score_y(part / 5), part / 5) for part in range(6)]
    rows = [
        (one, _rank(t, one), ["–" if value is None else t.amount(value) for value in values]) for one, values in known
    ]
    return CostPart(chosen, x_ticks, y_ticks, points, rows)


def _rank(t: PageTexts, standing: Standing) -> str:
    """Return a rank in the form that the standings show."""
    if not standing.rank:
        return "–"
    return t.whole(standing.rank) + ("=" if standing.tied else "")


def _value(standing: Standing, cost: str) -> float | None:
    if cost == "thinking":
        return standing.seconds_a_step
    declared: float | None = getattr(standing.cost, cost)
    return declared


def _score_y(score: float) -> float:
    return round(HEIGHT - BOTTOM - score * (HEIGHT - TOP - BOTTOM), 1)


class _Scale:
    """Logarithmic horizontal axis, with a strip at its left for values of 0, if there are any.

    Args:
        values: values to show, at least 0; may be empty.
    """

    def __init__(self, values: Sequence[float]) -> None:
        logs = [math.log10(value) for value in values if value > 0.0]
        self._has_zero = any(value == 0.0 for value in values)
        self._any = bool(logs)
        self._low = math.floor(min(logs, default=0.0) + 1e-9)
        self._high = max(math.ceil(max(logs, default=0.0) - 1e-9), self._low + 1)
        self._left = LEFT + (_ZERO if self._has_zero else 0)

    def place(self, value: float) -> float:
        """Return the horizontal position of a value in the picture."""
        if value == 0.0:
            return LEFT + _ZERO / 4
        share = (math.log10(value) - self._low) / (self._high - self._low)
        return round(self._left + share * (WIDTH - RIGHT - 8 - self._left), 1)

    def ticks(self) -> list[float]:
        """Return the values of the ticks."""
        powers = range(self._low, self._high + 1)
        every = -(-len(powers) // 6)
        factors = (1.0, 2.0, 5.0) if self._high - self._low <= _FINE else (1.0,)
        found = [factor * 10.0**power for power in powers[::every] for factor in factors]
        shown = [value for value in found if value <= 10.0**self._high * (1 + 1e-9)] if self._any else []
        return [0.0, *shown] if self._has_zero else shown

"""Coordinates of the charts on the pages, for SVG."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from arramon_server.board.standings import Rows
from arramon_server.scoring.aggregate import ROWS
from arramon_server.scoring.episode_scores import CTC_DISTANCES

WIDTH, HEIGHT = 420, 240
LEFT, RIGHT, TOP, BOTTOM = 44, 12, 12, 40

FRAME = {
    "width": WIDTH,
    "height": HEIGHT,
    "left": LEFT,
    "right": WIDTH - RIGHT,
    "bottom": HEIGHT - BOTTOM,
}
"""Positions of a chart's edges, for templates."""

_TOPS = (0.1, 0.2, 0.5, 1.0)
"""Possible upper ends of a vertical axis of fractions."""


@dataclass(frozen=True, slots=True)
class Tick:
    """A tick mark of an axis.

    Attributes:
        at: position along the axis, in the picture's units.
        value: the value at that position.
    """

    at: float
    value: float


@dataclass(frozen=True, slots=True)
class Curve:
    """A curve of a chart.

    Attributes:
        name: a row of a score table, or "open".
        points: points of the curve, in SVG's notation.
        band: outline of the confidence intervals, in SVG's notation; empty if there are none.
        dots: positions of the values; empty if they are not marked.
    """

    name: str
    points: str
    band: str = ""
    dots: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Chart:
    """A chart: curves over a horizontal axis of numbers and a vertical axis of fractions."""

    x_ticks: tuple[Tick, ...]
    y_ticks: tuple[Tick, ...]
    lines: tuple[Curve, ...]


def ctc_chart(rows: Rows) -> Chart:
    """Return the chart of CTC-k over k: the fraction of turns that end within k units of the target, with intervals."""
    top = _top(max(rows[row][metric].high for row in ROWS for metric in CTC_DISTANCES))
    ends = (min(CTC_DISTANCES.values()), max(CTC_DISTANCES.values()))
    lines = []
    for row in ROWS:
        values = [(k, rows[row][metric]) for metric, k in CTC_DISTANCES.items()]
        middle = [_place(k, ends, value.mean, top) for k, value in values]
        upper = [_place(k, ends, value.high, top) for k, value in values]
        lower = [_place(k, ends, value.low, top) for k, value in reversed(values)]
        lines.append(Curve(row, _points(middle), _points([*upper, *lower]), tuple(middle)))
    x_ticks = tuple(Tick(_place(k, ends, 0, top)[0], k) for k in CTC_DISTANCES.values())
    return Chart(x_ticks, _share_ticks(top), tuple(lines))


def unfinished_shares(steps: Sequence[int]) -> list[tuple[int, float]]:
    """Return the fraction of episodes not ended after each number of steps, as (steps, fraction) where it changes.

    Args:
        steps: number of steps of each episode; at least one episode.
    """
    shares, left = [(0, 1.0)], len(steps)
    counts: dict[int, int] = {}
    for number in sorted(steps):
        counts[number] = counts.get(number, 0) + 1
    for number, ended in counts.items():
        left -= ended
        shares.append((number, left / len(steps)))
    return shares


def unfinished_chart(shares: Sequence[tuple[int, float]]) -> Chart:
    """Return the chart of `unfinished_shares`, a falling step function."""
    ends = (0.0, float(max(shares[-1][0], 1)))
    corners: list[tuple[float, float]] = []
    for number, share in shares:
        x, y = _place(number, ends, share, 1.0)
        corners += [(x, corners[-1][1]), (x, y)] if corners else [(x, y)]
    x_ticks = tuple(Tick(_place(value, ends, 0, 1.0)[0], value) for value in _round_steps(ends[1]))
    return Chart(x_ticks, _share_ticks(1.0), (Curve("open", _points(corners)),))


def bar_segments(counts: Mapping[str, int]) -> list[tuple[str, int, float, float]]:
    """Return the segments of a stacked bar: name, count, start in percent, width in percent."""
    total, begin = max(sum(counts.values()), 1), 0.0
    bar = []
    for name, number in counts.items():
        width = 100.0 * number / total
        bar.append((name, number, round(begin, 2), round(width, 2)))
        begin += width
    return bar


def _place(x: float, ends: tuple[float, float], share: float, top: float) -> tuple[float, float]:
    across = LEFT + (x - ends[0]) / (ends[1] - ends[0]) * (WIDTH - LEFT - RIGHT)
    return round(across, 1), round(HEIGHT - BOTTOM - share / top * (HEIGHT - TOP - BOTTOM), 1)


def _points(places: Sequence[tuple[float, float]]) -> str:
    return " ".join(f"{x:g},{y:g}" for x, y in places)


def _share_ticks(top: float) -> tuple[Tick, ...]:
    return tuple(Tick(_place(0, (0, 1), top * part / 5, top)[1], top * part / 5) for part in range(6))


def _top(highest: float) -> float:
    return next((top for top in _TOPS if highest <= top), 1.0)


def _round_steps(most: float) -> list[float]:
    """Return three to six round numbers, starting at 0."""
    width = next(width for width in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 10_000) if most / width <= 5)
    return [float(number) for number in range(0, int(most) + 1, width)]

"""Plots of the statistics: distributions of lengths, linguistic properties, frequent words."""

import math
from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path

from PIL.Image import Image

from arramon_client.world import PHASES
from arramon_dataset.pictures.canvas import BLACK, WHITE, Canvas, Colour, add_title, stack
from arramon_dataset.statistics import paper
from arramon_dataset.statistics.histogram import BINS, bin_shares
from arramon_dataset.statistics.measure import FREQUENT, SplitStatistics
from arramon_dataset.statistics.properties import PROPERTIES
from arramon_server.errors import StorageError

_COLOURS: tuple[Colour, ...] = (
    (50, 90, 205), (205, 45, 45), (46, 150, 70), (135, 60, 165), (225, 140, 20), (20, 160, 170), (160, 110, 60),
)  # fmt: skip
"""Colours of the columns in order, reused from the start if there are more columns."""

_GREY: Colour = (222, 222, 222)

_WIDTH, _HEIGHT, _LEFT, _BOTTOM, _TOP, _RIGHT = 860, 310, 60, 40, 10, 20
"""Size of one panel and its margins, in pixels."""

_KEY_WIDTH, _KEY_HEIGHT, _KEYS = 130, 18, 6
"""Size of one legend entry in pixels, and number of entries per line."""


def write_plots(columns: Sequence[SplitStatistics], folder: Path) -> list[Path]:
    """Write all plots into a folder, which is created if missing.

    Returns:
        Paths: `words-a-turn.png`, `path-a-turn.png`, `properties.png`, `frequent-words.svg`.

    Raises:
        StorageError: if a file cannot be written.
    """
    pictures: dict[str, Callable[[Path], object]] = {
        "words-a-turn.png": _distributions(columns, "words").save,
        "path-a-turn.png": _distributions(columns, "path").save,
        "properties.png": _properties(columns).save,
        "frequent-words.svg": lambda path: path.write_text(_frequent_words(columns), encoding="utf-8"),
    }
    written = []
    for name, write in pictures.items():
        path = folder / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
            write(path)
        except OSError as error:
            raise StorageError(f"cannot write {path}: {error.strerror}") from error
        written.append(path)
    return written


def _distributions(columns: Sequence[SplitStatistics], measure: str) -> Image:
    """Return a line plot for each phase: share of turns by length, one line per column."""
    panels = []
    for phase in PHASES:
        width, stop = BINS[phase, measure]
        lines = [bin_shares(each.phases[phase].lengths.turns[measure], width, stop) for each in columns]
        shown = max(number for line in lines for number, share in enumerate(line) if share) + 1
        panel = _Panel(
            shown * width, max(map(max, lines)), [(_name(each), _colour(at)) for at, each in enumerate(columns)]
        )
        panel.axes(max(1, shown // 12) * width)
        for number, line in enumerate(lines):
            middles = [((at + 0.5) * width, share) for at, share in enumerate(line[:shown])]
            panel.line([(0, 0), *middles], _colour(number))
        panels.append(add_title(panel.canvas.image, [f"{phase}: {_MEASURED[measure, phase]} a turn, share of turns"]))
    return stack(panels)


_MEASURED = {
    ("words", "navigation"): "words of the instruction",
    ("words", "assembly"): "words of the instruction",
    ("path", "navigation"): "points of the path",
    ("path", "assembly"): "cells of the path",
}


def _properties(columns: Sequence[SplitStatistics]) -> Image:
    """Return a bar plot for each phase: one bar per property and column, and the paper's."""
    panels = []
    for phase in PHASES:
        shares = [[each.phases[phase].properties[name].episodes for name in PROPERTIES] for each in columns]
        shares.append([paper.PROPERTIES[phase][name] for name in PROPERTIES])
        keys = [*((_name(each), _colour(number)) for number, each in enumerate(columns)), ("paper", BLACK)]
        panel = _Panel(len(PROPERTIES), 1.0, keys)
        panel.axes(0)
        thick = 0.8 / len(shares)
        for number, series in enumerate(shares):
            for at, share in enumerate(series):
                panel.bar(at + 0.1 + number * thick, thick, share, keys[number][1])
        for at, name in enumerate(PROPERTIES):
            panel.label_x(at + 0.5, name.replace("discrete_3d", "3D discrete"))
        panels.append(add_title(panel.canvas.image, [f"{phase}: share of episodes by linguistic property"]))
    return stack(panels)


class _Panel:
    """One plot: x from 0 to `right`, shares from 0 to `top`, with a legend above."""

    def __init__(self, right: float, top: float, keys: Sequence[tuple[str, Colour]]) -> None:
        self._right, self._top = right, top
        self._margin = _TOP + _KEY_HEIGHT * math.ceil(len(keys) / _KEYS)
        self.canvas = Canvas((0, 0, _WIDTH, _HEIGHT), 1, WHITE)
        for number, (name, colour) in enumerate(keys):
            x, y = _LEFT + _KEY_WIDTH * (number % _KEYS), _HEIGHT - _TOP - _KEY_HEIGHT * (number // _KEYS)
            self.canvas.rectangle(x + 8, y, (8, 5), 0.0, colour)
            self.canvas.label(x + 22, y, name, size=12)

    def at(self, x: float, share: float) -> tuple[float, float]:
        """Return the canvas point of a data point."""
        across, up = _WIDTH - _LEFT - _RIGHT, _HEIGHT - _BOTTOM - self._margin
        return _LEFT + x / self._right * across, _BOTTOM + share / self._top * up

    def axes(self, every: float) -> None:
        """Draw lines at round shares, and labels on the x axis at multiples of `every`; none for 0."""
        step = next(step for step in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0) if self._top / step <= 6)
        for number in range(int(self._top / step) + 1):
            share = number * step
            if share <= 1:
                self.canvas.line([self.at(0, share), self.at(self._right, share)], _GREY, 1)
                self.canvas.label(_LEFT - 8, self.at(0, share)[1], f"{share:.0%}", anchor="rm")
        x = 0.0
        while every and x <= self._right:
            self.label_x(x, f"{x:g}")
            x += every

    def label_x(self, x: float, text: str) -> None:
        """Write text below the x axis."""
        self.canvas.label(self.at(x, 0)[0], _BOTTOM - 14, text, anchor="mm")

    def line(self, points: Sequence[tuple[float, float]], colour: Colour) -> None:
        """Draw a line through (x, share) points."""
        self.canvas.line([self.at(x, share) for x, share in points], colour, 2)

    def bar(self, x: float, width: float, share: float, colour: Colour) -> None:
        """Draw a bar whose left edge is at `x`."""
        left, bottom = self.at(x, 0)
        right, top = self.at(x + width, share)
        self.canvas.rectangle(
            (left + right) / 2, (bottom + top) / 2, ((right - left) / 2, (top - bottom) / 2), 0.0, colour
        )


def _frequent_words(columns: Sequence[SplitStatistics]) -> str:
    """Return bar charts of words as SVG: viewers have fonts for every script, the picture library does not."""
    parts, width, row, top = [], 300, 18, 52
    for down, phase in enumerate(PHASES):
        for across, each in enumerate(columns):
            words = each.phases[phase].frequent
            most = words[0][1] if words else 1
            x, y = across * width + 110, down * (top + FREQUENT * row) + top
            parts.append(f'<text x="{x}" y="{y - 18}" font-weight="bold">{escape(f"{_name(each)}: {phase}")}</text>')
            for rank, (word, count) in enumerate(words):
                line, bar = y + rank * row, count / most * 130
                fill = "#{:02x}{:02x}{:02x}".format(*_colour(across))
                parts.append(f'<text x="{x - 6}" y="{line + 11}" text-anchor="end">{escape(word)}</text>')
                parts.append(f'<rect x="{x}" y="{line}" width="{bar:.1f}" height="{row - 5}" fill="{fill}"/>')
                parts.append(f'<text x="{x + bar + 5:.1f}" y="{line + 11}" fill="#555">{count}</text>')
    size = f'width="{len(columns) * width}" height="{len(PHASES) * (top + FREQUENT * row)}"'
    style = 'font-family="sans-serif" font-size="13"'
    body = "\n".join(parts)
    ground = '<rect width="100%" height="100%" fill="white"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} {style}>\n{ground}\n{body}\n</svg>\n'


def _name(figures: SplitStatistics) -> str:
    return f"{figures.split} {figures.language}"


def _colour(number: int) -> Colour:
    return _COLOURS[number % len(_COLOURS)]

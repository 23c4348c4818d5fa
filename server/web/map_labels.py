"""Places for names on a section's map, where they cover neither each other nor the paths."""

import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from arramon_server.scoring.trajectory import Point2

LETTER = 1.5
"""Font size of a label, in units; `style.css` has it, too."""

_WIDTH, _ASCENT, _DESCENT = 0.62, 0.95, 0.4
"""Mean width of a letter, and the heights of a line above and below its baseline, as fractions of the font size."""

_GAP = 0.6
"""Gap beside a label, in units."""

_CLEAR = 0.6
"""Space around a label that is free of paths, in units: more than half of a path's width."""

_MARK, _DOT = 1.0, 0.4
"""Radius of the marks of the target and of the ends of paths, and of those of other things, in units."""

_DISTANCES = (1.2, 2.2, 3.4, 4.8, 6.4)
"""Distances of a label from its thing, in units, the best first."""

_DIRECTIONS = ((1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (1, 1), (-1, -1), (-1, 1))
"""Directions of a label from its thing, to the right and downwards, the best first."""

_ANCHORS = {1: "start", 0: "middle", -1: "end"}
"""Where the text of a label to the right, above or below, and to the left is anchored."""

_Box = tuple[float, float, float, float]
"""Left, top, right and bottom."""


@dataclass(frozen=True, slots=True)
class MapLabel:
    """A label on the map.

    Attributes:
        x, y: where its text is anchored.
        anchor: "start", "middle" or "end".
        name: the text.
        dot: position of the labelled thing.
    """

    x: float
    y: float
    anchor: str
    name: str
    dot: Point2


def place_labels(
    view: _Box, named: Sequence[tuple[str, Point2]], ways: Sequence[Sequence[Point2]] = (), scale: float = 1.0
) -> tuple[MapLabel, ...]:
    """Place labels so that they cover no other label, no path, and no mark of a path's end or of a thing.

    Labels for which there is no space in the view are left out.

    Args:
        view: the part of the map that is shown.
        named: texts with positions on the map, the most important first: the target.
        ways: paths on the map, each as its points.
        scale: size of the labels, as a multiple of the usual one.
    """
    placed: list[MapLabel] = []
    ends = [point for way in ways if way for point in (way[0], way[-1])]
    dots = [dot for _, dot in named]
    taken = [*(_around(point, _MARK) for point in (*ends, *dots[:1])), *(_around(dot, _DOT) for dot in dots)]
    for name, dot in named:
        for label, box in _candidates(name, dot, view, scale):
            if _is_within(box, view) and not any(_overlap(box, other) for other in taken) and _is_free(box, ways):
                placed.append(label)
                taken.append(box)
                break
    return tuple(placed)


def _candidates(name: str, dot: Point2, view: _Box, scale: float) -> list[tuple[MapLabel, _Box]]:
    """Return the places of a label, the best first, each with the box that it covers.

    Above and below its thing a label is moved to the side as far as the view demands.
    """
    size = LETTER * scale
    width = _WIDTH * size * sum(unicodedata.category(letter) != "Mn" for letter in name) + _GAP
    height = (_ASCENT + _DESCENT) * size
    found = []
    for distance in (scale * one for one in _DISTANCES):
        for right, down in _DIRECTIONS:
            x = dot[0] + right * distance
            if right == 0:
                x = max(view[0] + width / 2, min(x, view[2] - width / 2))
            left = x - width * (1 - right) / 2
            middle = dot[1] + down * (distance if right else distance + height / 2)
            box = (left, middle - height / 2, left + width, middle + height / 2)
            label = MapLabel(round(x, 2), round(box[3] - _DESCENT * size, 2), _ANCHORS[right], name, dot)
            found.append((label, box))
    return found


def _around(point: Point2, radius: float) -> _Box:
    return point[0] - radius, point[1] - radius, point[0] + radius, point[1] + radius


def _is_within(box: _Box, view: _Box) -> bool:
    return box[0] >= view[0] and box[1] >= view[1] and box[2] <= view[2] and box[3] <= view[3]


def _overlap(one: _Box, other: _Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _is_free(box: _Box, ways: Sequence[Sequence[Point2]]) -> bool:
    wide = box[0] - _CLEAR, box[1] - _CLEAR, box[2] + _CLEAR, box[3] + _CLEAR
    return not any(_crosses(wide, a, b) for way in ways for a, b in pairwise(way))


def _crosses(box: _Box, a: Point2, b: Point2) -> bool:
    """Return whether the line from a to b has a point in the box."""
    first, last = 0.0, 1.0  # of the line, as fractions of its length
    for axis in (0, 1):
        low, high, along = box[axis] - a[axis], box[axis + 2] - a[axis], b[axis] - a[axis]
        if along == 0:
            if low > 0 or high < 0:
                return False
        else:
            enters, leaves = sorted((low / along, high / along))
            first, last = max(first, enters), min(last, leaves)
    return first <= last

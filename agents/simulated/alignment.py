"""Alignment of an instruction with a path: the point at which each of its meaning rows (`slots.py`) is carried out."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from arramon_agents.reading.reader.slots import FACE, ROTATE, SLOTS, TARGET, TYPES, WHERE, Row
from arramon_agents.simulated.courses import Course
from arramon_agents.vl_map.features import NamedAttributes, named_attributes
from arramon_dataset.layout.solids import distance_from_rectangle
from arramon_lang.street_words import DEGREES

MAX_COST_DISTANCE, MAX_COST_TURN = 6.0, math.radians(60.0)
"""Distance from the thing of a row, in units, and difference from the turn of a row at which the cost reaches its
maximum, 1."""

UNKNOWN = 0.3
"""Cost of any place for a row without a thing or a turn."""

Costs = npt.NDArray[np.float64]

_NAMES = list(SLOTS)


def places_of(course: Course, rows: Sequence[Row]) -> list[int]:
    """Return the index of the path's point at which each row is carried out, by dynamic programming.

    Points are in order, and the total cost is minimal: distances from named things and differences from turns. A
    relation gets the point of its thing.
    """
    if not rows:
        return []
    costs = np.stack([_costs(course, row) for row in rows])
    types = [TYPES[row[0]] for row in rows]
    costs[[each == WHERE for each in types]] = 0.0
    costs[[each == TARGET for each in types], :-1] = 1e3
    total = np.zeros_like(costs)
    total[0] = costs[0]
    for number in range(1, len(rows)):
        total[number] = costs[number] + np.minimum.accumulate(total[number - 1])
    place = int(total[-1].argmin())
    places = [place]
    for number in range(len(rows) - 2, -1, -1):
        place = int(total[number, : place + 1].argmin())
        places.append(place)
    places.reverse()
    for number, each in enumerate(types):
        if each == WHERE and number:
            places[number] = places[number - 1]
    return places


def current_row(rows: Sequence[Row], places: Sequence[int], at: int) -> int:
    """Return the index of the row that is carried out at a point of the path: the first one with a later point."""
    steps = [number for number, row in enumerate(rows) if TYPES[row[0]] != WHERE]
    return next((number for number in steps if places[number] > at), steps[-1] if steps else 0)


def _costs(course: Course, row: Row) -> Costs:
    """Return the cost of each point of the path for a row, from 0 to about 1."""
    path, type_ = course.path, TYPES[row[0]]
    found = []
    thing = named_attributes(row, 0)
    away = _distances(course, thing) if thing is not None else None
    if type_ == ROTATE:
        turn = SLOTS["direction"][row[_NAMES.index("direction")]]
        found.append(_turns(course, math.radians(DEGREES[turn])) if turn else np.full(len(path), UNKNOWN))
    if away is not None and type_ != FACE:
        found.append(np.minimum(away.min(1) / MAX_COST_DISTANCE, 1.0))
    return np.mean(found, 0) if found else np.full(len(path), UNKNOWN)


def _distances(course: Course, thing: NamedAttributes) -> Costs | None:
    """Return the distances of points from the things that match, (points, things); None if nothing matches."""
    path, things = course.path, course.things
    fitting = [
        number
        for number, code in enumerate(things.codes)
        if code.kind in thing.kinds
        and (thing.colour is None or not thing.has_colour or code.colour == thing.colour)
        and (thing.look is None or code.look == thing.look)
    ]
    if fitting:
        places = things.places[fitting]
        distances: Costs = np.hypot(path[:, 0, None] - places[:, 0], path[:, 1, None] - places[:, 1])
        return distances
    walls = [
        distance_from_rectangle(
            path, np.array((house.x, house.z)), np.array((house.half_width, house.half_length)), house.heading
        )
        for house in course.world.section.buildings
        if thing.is_facade(house.facade)
    ]
    return np.stack(walls, 1) if walls else None


def _turns(course: Course, wanted: float) -> Costs:
    """Return the difference between the turn at each point and a turn, from 0 to 1."""
    path = course.path
    after = np.array([_heading(path, at, min(at + 2, len(path) - 1)) for at in range(len(path))])
    before = np.array([course.start[2] if at < 1 else _heading(path, max(at - 2, 0), at) for at in range(len(path))])
    off = (after - before - wanted + math.pi) % (2.0 * math.pi) - math.pi
    turned: Costs = np.minimum(np.abs(off) / MAX_COST_TURN, 1.0)
    return turned


def _heading(path: npt.NDArray[np.float64], start: int, end: int) -> float:
    dx, dz = path[end] - path[start]
    return math.atan2(dx, dz)

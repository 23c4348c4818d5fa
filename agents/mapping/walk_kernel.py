"""Compiled A* over the agent's actions on its map, for `walk_planner`."""

import math
from heapq import heappop, heappush

import numpy as np
import numpy.typing as npt

from arramon_agents.compilation import compiled

# Repeated here as plain numbers: compiled code on disk is renewed only when this file changes.
_HEADINGS = 12
_CELL = 0.25
_SIDE = 640
_SAMPLES = 4  # Places along a step that must not be blocked, at equal distances; the last one is its end.
_SQUARES = 4.0  # The search merges poses with one heading in squares of a quarter of a unit.
_MARGIN = 0.3  # Minimum decrease of the remaining distance for a pose to replace the nearest one found, in units.

PICK_UP_SIDE, PICK_UP_FROM, PICK_UP_TO = 0.42, 0.8, 1.9
"""Range for the pick-up, in units: to the side, and nearest and farthest ahead; the rules' box is 0.5 and 3."""

OTHER_SIDE, OTHER_MARGIN = 0.6, 0.1
"""Distance to the side below which another object may be picked up instead, and its lead in distance, in units."""

CIRCLE, LINE, PICK_UP = 0, 1, 2
"""Kinds of goals."""

Floats = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]


@compiled
def pick_up_offset(place: Floats, others: Floats, x: float, z: float, sin: float, cos: float) -> float:
    """Return the sideways offset of an object from a pose at which a pick-up takes it and no other; -1 elsewhere.

    Args:
        place: (2,) or more: the object's (x, z).
        others: (n, 2) of (x, z): the other objects. The nearest object in the box is picked up.
        x, z, sin, cos: the pose; sine and cosine of its heading.
    """
    dx, dz = place[0] - x, place[1] - z
    ahead, aside = dx * sin + dz * cos, abs(dx * cos - dz * sin)
    if not (PICK_UP_FROM <= ahead <= PICK_UP_TO and aside <= PICK_UP_SIDE):
        return -1.0
    for i in range(len(others)):
        ox, oz = others[i, 0] - x, others[i, 1] - z
        is_in_box = abs(ox * cos - oz * sin) < OTHER_SIDE and ox * sin + oz * cos > -OTHER_MARGIN
        if is_in_box and math.hypot(ox, oz) < math.hypot(dx, dz) + OTHER_MARGIN:
            return -1.0
    return float(aside)


@compiled
def _remaining(kind: int, goal: Floats, x: float, z: float) -> float:
    """Return the distance that is left from a place to a goal, in units; 0 or less where it is reached."""
    if kind == LINE:
        return float((goal[0] - x) * goal[2] + (goal[1] - z) * goal[3])
    return float(math.hypot(goal[0] - x, goal[1] - z) - goal[2])


@compiled
def can_step(blocked: npt.NDArray[np.uint8], x: float, z: float, sin: float, cos: float) -> bool:
    """Return whether a step from (x, z) is not known to be blocked; sine and cosine are of its heading.

    The agent may be closer to obstacles than its map allows, so from a blocked cell the next one may be blocked too.
    """
    half = _SIDE / 2
    for sample in range(_SAMPLES, 0, -1):
        share = sample / _SAMPLES
        row, column = int((x + share * sin) / _CELL + half), int((z + share * cos) / _CELL + half)
        if row < 0 or column < 0 or row >= _SIDE or column >= _SIDE:
            return False
        if blocked[row * _SIDE + column]:
            row, column = int(x / _CELL + half), int(z / _CELL + half)
            is_inside = 0 <= row < _SIDE and 0 <= column < _SIDE
            return bool(sample == 1 and is_inside and blocked[row * _SIDE + column])
    return True


@compiled
def _is_closed(closed: Numbers, x: float, z: float, heading: int) -> bool:
    """Return whether a step turned out to be blocked; its key is that of `motion.step_key`."""
    key_x, key_z = round(x * 10.0), round(z * 10.0)
    for i in range(len(closed)):  # noqa: SIM110 - numba compiles plain loops
        if closed[i, 0] == key_x and closed[i, 1] == key_z and closed[i, 2] == heading:
            return True
    return False


@compiled
def _step_cost(
    costs: Floats, first_row: int, first_column: int, oblique_cost: float, kind: int, goal: Floats, x: float, z: float
) -> float:
    """Return the cost of a step that ends at (x, z), with `oblique_cost` added; -1 where a walk does not go."""
    row, column = int(x / _CELL + _SIDE / 2) - first_row, int(z / _CELL + _SIDE / 2) - first_column
    if row < 0 or column < 0 or row >= costs.shape[0] or column >= costs.shape[1]:
        return -1.0
    if kind == LINE and abs((x - goal[0]) * goal[3] - (z - goal[1]) * goal[2]) > goal[4]:
        return -1.0
    return float(costs[row, column]) + oblique_cost


@compiled
def _end_offset(kind: int, goal: Floats, others: Floats, x: float, z: float, sin: float, cos: float) -> float:
    """Return the sideways offset of the object if a walk may end at a pose, or 0 if none is wanted; -1 elsewhere."""
    if kind == PICK_UP:
        return pick_up_offset(goal, others, x, z, sin, cos)
    return 0.0 if _remaining(kind, goal, x, z) <= 0.0 else -1.0


@compiled
def search(
    blocked: npt.NDArray[np.uint8],
    costs: Floats,
    first_row: int,
    first_column: int,
    steps: Floats,
    closed: Numbers,
    start_x: float,
    start_z: float,
    start_heading: int,
    axis: int,
    turn_cost: float,
    oblique_cost: float,
    offset_cost: float,
    kind: int,
    goal: Floats,
    others: Floats,
    most: int,
) -> tuple[Numbers, bool]:
    """Return the headings of the cheapest walk, and whether it reaches the goal or only the nearest place found.

    Args:
        blocked: (_SIDE * _SIDE,) of the map.
        costs: (rows, columns) cost of a step by the cell in which it ends.
        first_row, first_column: the map's cell of the first of `costs`; a walk does not leave them.
        steps: (12, 2) the (x, z) of a step in each heading.
        closed: (n, 3) step keys of steps that turned out to be blocked.
        start_x, start_z, start_heading: pose at the start.
        axis: direction of the streets, 0, 1 or 2.
        turn_cost, oblique_cost: of a turn of 30 degrees; extra of a step that is not along the streets or across them.
        offset_cost: of each unit of an object's sideways offset at the end.
        kind: of the goal.
        goal: CIRCLE: (x, z, radius). LINE: (x, z, sine and cosine of the course, farthest to its side). PICK_UP: (x, z,
            farthest distance).
        others: (n, 2) objects that must not be picked up instead.
        most: number of poses to expand.

    Returns:
        (n,) the heading before each action and after the last one: an action is a step if the next heading is equal.
    """
    capacity = 4 * most + 8
    xs, zs, spent = np.empty(capacity), np.empty(capacity), np.empty(capacity)
    headings, before = np.empty(capacity, np.int64), np.empty(capacity, np.int64)
    xs[0], zs[0], spent[0], headings[0], before[0] = start_x, start_z, 0.0, start_heading, -1
    expanded = {np.int64(-1)}
    queue = [(0.0, 0)]
    count, last, nearest = 1, 0, _remaining(kind, goal, start_x, start_z)
    is_reached = False
    while len(queue) > 0 and len(expanded) <= most:
        number = heappop(queue)[1]
        x, z, heading = xs[number], zs[number], headings[number]
        if heading >= _HEADINGS:
            last, is_reached = before[number], True
            break
        key = np.int64((math.floor(x * _SQUARES) * 8192 + math.floor(z * _SQUARES)) * _HEADINGS + heading)
        if key in expanded:
            continue
        expanded.add(key)
        sin, cos = steps[heading, 0], steps[heading, 1]
        offset = _end_offset(kind, goal, others, x, z, sin, cos)
        if offset >= 0.0:
            headings[count], before[count] = _HEADINGS, number
            heappush(queue, (spent[number] + offset_cost * offset, count))
            count += 1
        left = _remaining(kind, goal, x, z)
        if left < nearest - _MARGIN:
            last, nearest = number, left
        for move in range(3):
            new_x, new_z, new_heading, more = x, z, heading, turn_cost
            if move == 0:
                new_x, new_z = x + sin, z + cos
                oblique = oblique_cost if (heading - axis) % 3 else 0.0
                more = _step_cost(costs, first_row, first_column, oblique, kind, goal, new_x, new_z)
                if more < 0.0 or _is_closed(closed, x, z, heading) or not can_step(blocked, x, z, sin, cos):
                    continue
            else:
                new_heading = (heading + (1 if move == 1 else _HEADINGS - 1)) % _HEADINGS
            xs[count], zs[count], headings[count], before[count] = new_x, new_z, new_heading, number
            spent[count] = spent[number] + more
            heappush(queue, (spent[count] + max(_remaining(kind, goal, new_x, new_z), 0.0), count))
            count += 1
    path = [headings[last]]
    while before[last] >= 0:
        last = before[last]
        path.append(headings[last])
    return np.array(path[::-1]), is_reached

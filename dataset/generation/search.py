"""Compiled searches over a section's ground: Dijkstra from one node to all others, and A* in the agent's action space.

Costs are integers in thousandths of a step, and places are sums of twelve fixed steps, so every machine finds the same
path.
"""

import numpy as np
import numpy.typing as npt

from arramon_server.sim.raster.compilation import cached, inlined

_NOWHERE = 2**31 - 1

# Repeated here as plain numbers: compiled code on disk is renewed only when this file changes.
_CELL = 0.125
_STRIDE = 3
_HEADINGS = 12
_GRAIN = 4.0  # The search identifies places with the same heading in one square of a quarter of a unit.
_SAMPLES = 8  # Segments of a step; the clearance is sampled at the end of each.
_BITS = 24  # A heap entry holds a cost and, in this many low bits, a node number.
_MASK = (1 << _BITS) - 1

Numbers = npt.NDArray[np.int32]
Places = npt.NDArray[np.float64]
Heap = npt.NDArray[np.int64]


@inlined
def _push(heap: Heap, size: int, entry: int) -> int:
    i = size
    while i > 0:
        above = (i - 1) >> 1
        if heap[above] <= entry:
            break
        heap[i] = heap[above]
        i = above
    heap[i] = entry
    return size + 1


@inlined
def _pop(heap: Heap, size: int) -> tuple[int, int]:
    """Remove the least entry, at index 0, and return it with the new size."""
    top, size = heap[0], size - 1
    entry = heap[size]
    i = 0
    while True:
        below = 2 * i + 1
        if below >= size:
            break
        if below + 1 < size and heap[below + 1] < heap[below]:
            below += 1
        if entry <= heap[below]:
            break
        heap[i] = heap[below]
        i = below
    heap[i] = entry
    return top, size


@cached
def dijkstra(
    clearance: Numbers,
    discomfort: Numbers,
    need: int,
    column: int,
    row: int,
    cost: Numbers,
    length: Numbers,
    heap: Heap,
) -> None:
    """Run Dijkstra from one node to all others, filling `cost` and `length`.

    Args:
        clearance: (columns, rows) int32 by cell, thousandths of a unit.
        discomfort: (FAR + 1,) int32 by clearance, cost of a unit of path.
        need: minimum clearance of a node, in thousandths of a unit.
        column, row: the node to start from.
        cost: (node columns, node rows) int32, thousandths of a step; 2**31 - 1 where unreachable.
        length: the same shape, thousandths of a unit along the cheapest path.
        heap: int64 buffer, more than sixteen times as long as there are nodes.
    """
    columns, rows = cost.shape
    cost[:] = _NOWHERE
    length[:] = _NOWHERE
    cost[column, row] = 0
    length[column, row] = 0
    size = _push(heap, 0, (column * rows + row))
    while size > 0:
        entry, size = _pop(heap, size)
        here = entry & _MASK
        i, j = here // rows, here % rows
        if (entry >> _BITS) > cost[i, j]:
            continue
        clear = clearance[i * _STRIDE, j * _STRIDE]
        for di in range(-2, 3):
            for dj in range(-2, 3):
                far = di * di + dj * dj
                if far != 1 and far != 2 and far != 5:
                    continue
                a, b = i + di, j + dj
                if a < 0 or b < 0 or a >= columns or b >= rows:
                    continue
                other = clearance[a * _STRIDE, b * _STRIDE]
                if other < need or clearance[(i + a) * _STRIDE // 2, (j + b) * _STRIDE // 2] < need:
                    continue
                edge_length = 375 if far == 1 else (530 if far == 2 else 838)
                new = cost[i, j] + edge_length * (discomfort[clear] + discomfort[other]) // 2000
                if new < cost[a, b]:
                    cost[a, b] = new
                    length[a, b] = length[i, j] + edge_length
                    size = _push(heap, size, (new << _BITS) | (a * rows + b))


@inlined
def _clear(
    clearance: Numbers, left: float, bottom: float, x: float, z: float, dx: float, dz: float, samples: int, need: int
) -> int:
    """Return the clearance at the end of the segment from (x, z) by (dx, dz), or -1 if a sample is below `need`."""
    columns, rows = clearance.shape
    end = -1
    for i in range(1, samples + 1):
        share = i / samples
        a, b = int((x + dx * share - left) / _CELL), int((z + dz * share - bottom) / _CELL)
        if a < 0 or b < 0 or a >= columns or b >= rows or clearance[a, b] < need:
            return -1
        end = clearance[a, b]
    return int(end)


@inlined
def _remaining_cost(cost: Numbers, left: float, bottom: float, x: float, z: float) -> int:
    """Return the remaining cost, interpolated from the four nodes around (x, z); _NOWHERE if none is reachable."""
    columns, rows = cost.shape
    # A node's place is the centre of its cell.
    u, v = (x - left) / _CELL - 0.5, (z - bottom) / _CELL - 0.5
    i, j = int(u) // _STRIDE, int(v) // _STRIDE
    if i < 0 or j < 0 or i + 1 >= columns or j + 1 >= rows:
        return _NOWHERE
    p, q = u / _STRIDE - i, v / _STRIDE - j
    c00, c01, c10, c11 = cost[i, j], cost[i, j + 1], cost[i + 1, j], cost[i + 1, j + 1]
    least = min(min(c00, c01), min(c10, c11))
    if max(max(c00, c01), max(c10, c11)) == _NOWHERE:
        return _NOWHERE if least == _NOWHERE else least + 200
    return int(c00 * (1 - p) * (1 - q) + c01 * (1 - p) * q + c10 * p * (1 - q) + c11 * p * q)


@inlined
def _sees(
    clearance: Numbers, left: float, bottom: float, x: float, z: float, sin: float, cos: float, goal: Places
) -> float:
    """Return the target's offset to the side if it is in reach and view, else -1.0; `goal` as in `a_star`."""
    to_x, to_z = goal[0] - x, goal[1] - z
    ahead, aside = to_x * sin + to_z * cos, abs(to_x * cos - to_z * sin)
    if ahead < goal[2] or ahead > goal[3] or aside > goal[4]:
        return -1.0
    return aside if _clear(clearance, left, bottom, x, z, to_x, to_z, 16, int(goal[5])) >= 0 else -1.0


@cached
def a_star(
    clearance: Numbers,
    discomfort: Numbers,
    axes: Numbers,
    directions: Numbers,
    oblique: Numbers,
    left: float,
    bottom: float,
    cost: Numbers,
    steps: Places,
    start_x: float,
    start_z: float,
    goal: Places,
    need: int,
    turn_cost: int,
    aside_cost: int,
    limit: int,
    best: Numbers,
    stamps: Numbers,
    stamp: int,
    place_x: Places,
    place_z: Places,
    facing: Numbers,
    before: Numbers,
    spent: Numbers,
    heap: Heap,
) -> int:
    """Run A* and return the number of the goal node, or -1. Nodes are linked by `before`; node 0 is the start.

    Args:
        clearance, discomfort: as for `dijkstra`.
        axes: (columns, rows) int32 by cell, direction of the street in degrees, in [0, 90).
        directions: (12,) int32, each heading in whole degrees, in [0, 90).
        oblique: (46,) int32, extra cost of a step by its angle to the street's direction, in degrees.
        left, bottom: x and z of the raster's corner, in units.
        cost: the target's cost field, from `dijkstra`.
        steps: (12, 2) float64, the (x, z) of one step ahead in each heading, clockwise.
        start_x, start_z: in units.
        goal: (6,) float64: the target's x and z; its minimum and maximum distance ahead and maximum sideways offset at
            the end, in units; the clearance needed along the line of sight to it, in thousandths of a unit.
        need: minimum clearance along a whole step, in thousandths of a unit.
        turn_cost: cost of a turn of 30 degrees.
        aside_cost: cost of each unit of the target's sideways offset at the end.
        limit: number of expanded nodes after which the search fails.
        best: (squares along x, along z, 12) int32 buffer, lowest cost at which a place was reached.
        stamps: the same shape: `stamp` where `best` belongs to this search, -`stamp` where the place was expanded.
        place_x, place_z: (n,) float64, by node.
        facing: (n,) int32, heading by node, plus 12 for a goal.
        before: (n,) int32, previous node, by node; -1 for the start.
        spent: (n,) int32, cost so far, by node.
        heap: (n,) int64.
    """
    capacity = len(place_x) - 4
    place_x[0], place_z[0], facing[0], before[0], spent[0] = start_x, start_z, 0, -1, 0
    h = _remaining_cost(cost, left, bottom, start_x, start_z)
    if h == _NOWHERE:
        return -1
    count, looked = 1, 0
    size = _push(heap, 0, h << _BITS)
    while size > 0 and looked < limit and count < capacity:
        entry, size = _pop(heap, size)
        number = int(entry & _MASK)
        if facing[number] >= _HEADINGS:
            return number
        x, z, heading = place_x[number], place_z[number], facing[number]
        a, b = int((x - left) * _GRAIN), int((z - bottom) * _GRAIN)
        if stamps[a, b, heading] == -stamp:
            continue  # Already expanded from a cheaper node.
        stamps[a, b, heading] = -stamp
        looked += 1
        sin, cos = steps[heading, 0], steps[heading, 1]
        aside = _sees(clearance, left, bottom, x, z, sin, cos, goal)
        if aside >= 0.0:
            facing[count], before[count] = heading + _HEADINGS, number
            whole = spent[number] + int(aside_cost * aside)
            size = _push(heap, size, (whole << _BITS) | count)
            count += 1
        for move in range(3):
            new_heading, new_x, new_z, more = heading, x, z, turn_cost
            if move == 0:
                end = _clear(clearance, left, bottom, x, z, sin, cos, _SAMPLES, need)
                if end < 0:
                    continue
                new_x, new_z = x + sin, z + cos
                axis = axes[int((new_x - left) / _CELL), int((new_z - bottom) / _CELL)]
                off = abs(directions[heading] - axis)
                more = discomfort[end] + oblique[min(off, 90 - off)]
            else:
                new_heading = (heading + (1 if move == 1 else _HEADINGS - 1)) % _HEADINGS
            h = _remaining_cost(cost, left, bottom, new_x, new_z)
            if h == _NOWHERE:
                continue
            i, j = int((new_x - left) * _GRAIN), int((new_z - bottom) * _GRAIN)
            new = spent[number] + more
            mark = stamps[i, j, new_heading]
            if mark == -stamp or (mark == stamp and best[i, j, new_heading] <= new):
                continue
            stamps[i, j, new_heading] = stamp
            best[i, j, new_heading] = new
            place_x[count], place_z[count], facing[count], before[count] = new_x, new_z, new_heading, number
            spent[count] = new
            size = _push(heap, size, ((new + h) << _BITS) | count)
            count += 1
    return -1

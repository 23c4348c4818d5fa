"""Assembly orders of the sample: the target's cell, its relation to a landmark, and the agent's path."""

import heapq
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from random import Random

from arramon_server.sim.catalogue import ALL_TYPES, ObjectType
from arramon_server.sim.room import START, RoomCell, RoomPosition

RELATIONS = ("on_top_of", "left_of", "right_of", "behind", "in_front_of")

OFFSETS = {"on_top_of": (0, 0), "left_of": (1, 0), "right_of": (-1, 0), "behind": (0, -1), "in_front_of": (0, 1)}
"""The landmark's position, in (columns, rows) from the target's cell, as the agent sees it from the start tile."""

PLAIN = {
    "ahead_1": RoomCell(2, 1),
    "ahead_2": RoomCell(2, 2),
    "brick_wall": RoomCell(2, 3),
    "turn_right": RoomCell(3, 0),
    "turn_left": RoomCell(1, 0),
}
"""Relations without a landmark, and their target cells."""


@dataclass(frozen=True)
class Order:
    """The assembly of one turn.

    Attributes:
        relation: one of RELATIONS, or of PLAIN.
        landmark: the object of the relation; None in a plain order.
        stand: the landmark's cell.
        placement: the target's placement.
        path: the agent's cells, from the start tile.
        actions: 0 forward, 1 left, 2 right, 3 place.
    """

    relation: str
    landmark: ObjectType | None
    stand: RoomCell | None
    placement: RoomPosition
    path: tuple[RoomCell, ...]
    actions: tuple[int, ...]


def draw_orders(targets: tuple[ObjectType, ObjectType], stacked: bool, random: Random) -> tuple[Order, Order]:
    """Draw the orders of both turns; if `stacked`, the second target goes on top of the first."""
    decoys = random.sample([other for other in ALL_TYPES if other not in targets], 2)
    while True:
        first = _draw(decoys[0], None, (), random)
        if first is None or (stacked and first.placement.level > 1):
            continue
        landmark = targets[0] if stacked or random.random() < 0.25 else decoys[1]
        known = RoomCell(first.placement.column, first.placement.row) if landmark is targets[0] else None
        if known and first.placement.level > 1:
            continue
        relations = ("on_top_of",) if stacked else RELATIONS[1:] if known else ()
        second = _draw(landmark, known, relations, random, taken=_cells(first))
        if second is None:
            continue
        # Objects of one turn must not be on the path of the other.
        walked = {*first.path, *second.path}
        if not walked & {*_cells(first), *_cells(second)}:
            return first, second


def _cells(order: Order) -> set[RoomCell]:
    """Return the cells that the order fills."""
    cells = {RoomCell(order.placement.column, order.placement.row), order.stand}
    return {cell for cell in cells if cell is not None}


def _draw(
    landmark: ObjectType,
    known: RoomCell | None,
    relations: Sequence[str],
    random: Random,
    taken: Collection[RoomCell] = (),
) -> Order | None:
    """Draw an order; None if the draw is invalid.

    Args:
        landmark: used in orders with a landmark.
        known: the landmark's cell, if it is in the room already.
        relations: relations to draw from; all, and the plain ones, if empty.
        random: random number generator.
        taken: filled cells.
    """
    relation = random.choice(relations or (*RELATIONS, "on_top_of", *PLAIN))
    if relation in PLAIN:
        target, stand = PLAIN[relation], None
    else:
        columns, rows = OFFSETS[relation]
        if known:
            stand = known
            target = RoomCell(stand.column - columns, stand.row - rows)
        else:
            target = RoomCell(random.randint(1, 4), random.randint(0, 3))
            stand = RoomCell(target.column + columns, target.row + rows)
            if stand in taken:
                return None
    on_top = relation == "on_top_of"
    inside = 1 <= target.column <= 4 and target.is_inside() and (stand is None or stand.is_inside())
    if not inside or START in (target, stand) or (target in taken and not (on_top and known)):
        return None
    way = _way(target, {target, *taken, *({stand} if stand else ())})
    if way is None:
        return None
    placement = RoomPosition(target.column, 2 if on_top else 1, target.row)
    return Order(relation, None if stand is None else landmark, stand, placement, *way)


def _way(target: RoomCell, filled: Collection[RoomCell]) -> tuple[tuple[RoomCell, ...], tuple[int, ...]] | None:
    """Return cells and actions of the shortest way from the start tile to a cell that faces `target`; None if none."""
    waiting: list[tuple[int, RoomCell, int, tuple[RoomCell, ...], tuple[int, ...]]] = [(0, START, 0, (START,), ())]
    seen = set()
    while waiting:
        cost, cell, quarter, path, actions = heapq.heappop(waiting)
        ahead = cell.ahead(90.0 * quarter)
        if ahead == target:
            return path, (*actions, 3)
        if (cell, quarter) in seen:
            continue
        seen.add((cell, quarter))
        if 1 <= ahead.column <= 4 and 0 <= ahead.row <= 2 and ahead not in filled:
            heapq.heappush(waiting, (cost + 1, ahead, quarter, (*path, ahead), (*actions, 0)))
        for turn, action in ((-1, 1), (1, 2)):
            heapq.heappush(waiting, (cost + 3, cell, (quarter + turn) % 4, path, (*actions, action, action, action)))
    return None

"""Assembly orders for the sample: where a target goes, in relation to what, and the way there."""

import heapq
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from random import Random

from server.sim.catalogue import ALL_TYPES, ObjectType
from server.sim.room import START, Placement, Square

RELATIONS = ("on_top_of", "left_of", "right_of", "behind", "in_front_of")

OFFSETS = {"on_top_of": (0, 0), "left_of": (1, 0), "right_of": (-1, 0), "behind": (0, -1), "in_front_of": (0, 1)}
"""Where the landmark stands, in (columns, rows) from the target's cell, as the agent sees it from the start tile."""

PLAIN = {
    "ahead_1": Square(2, 1),
    "ahead_2": Square(2, 2),
    "brick_wall": Square(2, 3),
    "turn_right": Square(3, 0),
    "turn_left": Square(1, 0),
}
"""Orders that name no other object, and their cells."""


@dataclass(frozen=True)
class Order:
    """One turn's assembly.

    Attributes:
        relation: one of RELATIONS, or of PLAIN.
        landmark: what the target stands to in that relation; None in a plain order.
        stand: the landmark's cell.
        placement: where the target goes.
        path: the agent's cells, from the start tile.
        actions: 0 forward, 1 left, 2 right, 3 place.
    """

    relation: str
    landmark: ObjectType | None
    stand: Square | None
    placement: Placement
    path: tuple[Square, ...]
    actions: tuple[int, ...]


def draw_orders(targets: tuple[ObjectType, ObjectType], stacked: bool, random: Random) -> tuple[Order, Order]:
    """The orders of both turns; `stacked`: the second target goes on top of the first."""
    decoys = random.sample([other for other in ALL_TYPES if other not in targets], 2)
    while True:
        first = _draw(decoys[0], None, (), random)
        if first is None or (stacked and first.placement.level > 1):
            continue
        landmark = targets[0] if stacked or random.random() < 0.25 else decoys[1]
        known = Square(first.placement.column, first.placement.row) if landmark is targets[0] else None
        if known and first.placement.level > 1:
            continue
        relations = ("on_top_of",) if stacked else RELATIONS[1:] if known else ()
        second = _draw(landmark, known, relations, random, taken=_cells(first))
        if second is None:
            continue
        # Whatever stands in the room when a turn begins must not be where the other turn walks.
        walked = {*first.path, *second.path}
        if not walked & {*_cells(first), *_cells(second)}:
            return first, second


def _cells(order: Order) -> set[Square]:
    """The cells that the order fills."""
    cells = {Square(order.placement.column, order.placement.row), order.stand}
    return {cell for cell in cells if cell is not None}


def _draw(
    landmark: ObjectType,
    known: Square | None,
    relations: Sequence[str],
    random: Random,
    taken: Collection[Square] = (),
) -> Order | None:
    """An order at random, or None where the draw does not work out.

    Args:
        landmark: for the orders that have one.
        known: the landmark's cell, where it stands already.
        relations: to draw from; any, and the plain ones, if empty.
        random: draws everything.
        taken: cells that are filled.
    """
    relation = random.choice(relations or (*RELATIONS, "on_top_of", *PLAIN))
    if relation in PLAIN:
        target, stand = PLAIN[relation], None
    else:
        columns, rows = OFFSETS[relation]
        if known:
            stand = known
            target = Square(stand.column - columns, stand.row - rows)
        else:
            target = Square(random.randint(1, 4), random.randint(0, 3))
            stand = Square(target.column + columns, target.row + rows)
            if stand in taken:
                return None
    on_top = relation == "on_top_of"
    inside = 1 <= target.column <= 4 and target.is_inside() and (stand is None or stand.is_inside())
    if not inside or START in (target, stand) or (target in taken and not (on_top and known)):
        return None
    way = _way(target, {target, *taken, *({stand} if stand else ())})
    if way is None:
        return None
    placement = Placement(target.column, 2 if on_top else 1, target.row)
    return Order(relation, None if stand is None else landmark, stand, placement, *way)


def _way(target: Square, filled: Collection[Square]) -> tuple[tuple[Square, ...], tuple[int, ...]] | None:
    """The way with the fewest actions from the start tile to where `target` is ahead: its cells and its actions."""
    waiting: list[tuple[int, Square, int, tuple[Square, ...], tuple[int, ...]]] = [(0, START, 0, (START,), ())]
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

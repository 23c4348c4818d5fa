"""Random assembly tasks: the target cells of both objects, the ground truth, and the decoys."""

from collections.abc import Collection
from dataclasses import dataclass
from heapq import heappop, heappush
from random import Random

from arramon_client.world import COLUMNS, ROWS, Action
from arramon_dataset.release.missing_objects import DECOYS, arrange_decoys
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.room import START, RoomCell, RoomPosition
from arramon_server.sim.rules import PlacedObject

FIRST_COLUMN = 1
"""First column of target cells: the original's are in columns 1 to 4, never 0."""

ON_DECOY, ON_FIRST = 0.29, 0.06
"""Share of targets on top of a decoy, and share of second targets on top of the first, as in the original."""

TARGET_CELLS = tuple(
    RoomCell(column, row)
    for column in range(FIRST_COLUMN, COLUMNS)
    for row in range(ROWS)
    if RoomCell(column, row) != START
)

QUARTER = 3
"""Turns of 30 degrees in a quarter turn."""


@dataclass(frozen=True, slots=True)
class AssemblyTask:
    """The assembly task of one turn.

    Attributes:
        cell: the target cell.
        path: cells of the ground truth, starting at START.
        actions: actions of the ground truth, the placement included.
    """

    cell: RoomPosition
    path: tuple[RoomCell, ...]
    actions: tuple[Action, ...]


def draw_tasks(random: Random) -> tuple[AssemblyTask, AssemblyTask]:
    """Return random assembly tasks for both turns."""
    first, second = random.sample(TARGET_CELLS, 2)
    levels = [2 if random.random() < ON_DECOY else 1 for _ in range(2)]
    if levels[0] == 1 and random.random() < ON_FIRST / (1.0 - ON_DECOY):
        second, levels[1] = first, 2
    # Paths avoid the other turn's cell: it holds an object in turn 2, and may hold a decoy in turn 1.
    walks = (walk_to(first, {second} - {first}), walk_to(second, {first} - {second}))
    return tuple(  # type: ignore[return-value]  # Two of them.
        AssemblyTask(RoomPosition(cell.column, level, cell.row), path, (*actions, Action.INTERACT))
        for cell, level, (path, actions) in zip((first, second), levels, walks, strict=True)
    )


def walk_to(target: RoomCell, blocked: Collection[RoomCell]) -> tuple[tuple[RoomCell, ...], tuple[Action, ...]]:
    """Return the shortest path from START to where `target` is the cell ahead, and its actions without placement.

    Args:
        target: a cell other than START.
        blocked: cells that the path must not enter.

    Raises:
        ValueError: if there is no path.
    """
    queue: list[tuple[int, int, int, tuple[RoomCell, ...], tuple[Action, ...]]] = [(0, 0, 0, (START,), ())]
    closed: set[tuple[RoomCell, int]] = set()
    pushed = 0
    while queue:
        cost, _, quarter, path, actions = heappop(queue)
        ahead = path[-1].ahead(90.0 * quarter)
        if ahead == target:
            return path, actions
        if (path[-1], quarter) in closed:
            continue
        closed.add((path[-1], quarter))
        following = [
            (cost + QUARTER, (quarter + 1) % 4, path, (*actions, *[Action.RIGHT] * QUARTER)),
            (cost + QUARTER, (quarter - 1) % 4, path, (*actions, *[Action.LEFT] * QUARTER)),
        ]
        if ahead.is_inside() and ahead not in blocked:
            following.append((cost + 1, quarter, (*path, ahead), (*actions, Action.FORWARD)))
        for new_cost, new_quarter, new_path, new_actions in following:
            pushed += 1
            heappush(queue, (new_cost, pushed, new_quarter, new_path, new_actions))
    raise ValueError(f"there is no path to {target} with {sorted(blocked)} blocked")


def draw_decoys(
    key: str, targets: tuple[ObjectType, ObjectType], tasks: tuple[AssemblyTask, AssemblyTask]
) -> tuple[PlacedObject, ...] | None:
    """Return the room's eight decoys, off the paths of both ground truths, or None if they do not fit.

    Args:
        key: seed of all random choices.
        targets: object types of both turns.
        tasks: of both turns.
    """
    first, second = tasks
    found = arrange_decoys(key, targets, (first.cell, second.cell), (first.path, second.path), ((), ()))
    if len(found) < DECOYS:
        return None
    return tuple(PlacedObject(kind, RoomPosition(cell.column, 1, cell.row)) for kind, cell in found)

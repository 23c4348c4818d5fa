"""Description of a turn's assembly room as text, a plan from above, for writers' and readers' sheets."""

from arramon_client.world import COLUMNS, ROWS
from arramon_server.episodes.episode import Episode
from arramon_server.sim.room import START
from arramon_server.sim.rules import PlacedObject

WALLS = "walls: brick ahead (beyond the top row), wood right, spotted left, striped behind (below the bottom row)"


def room_before(episode: Episode, number: int) -> tuple[PlacedObject, ...]:
    """Return the objects in the room when the assembly of turn 1 or 2 begins, with turn 1's target placed right."""
    first = episode.turns[0]
    placed = (PlacedObject(first.target.type, first.target_cell),) if number == 2 else ()
    return (*episode.decoys, *placed)


def room_facts(episode: Episode, number: int, *, with_goal: bool) -> list[str]:
    """Return lines that describe the room; the goal's place only `with_goal`.

    Columns are counted from the left (0) and rows from the start tile's (0), as seen from the tile facing the brick
    wall.
    """
    turn = episode.turns[number - 1]
    lines = [f"room, from above; YOU are on the tile of column {START.column}, row {START.row}, and face up; {WALLS}"]
    stacks: dict[tuple[int, int], list[PlacedObject]] = {}
    for item in sorted(room_before(episode, number), key=lambda item: item.placement.level):
        stacks.setdefault((item.placement.column, item.placement.row), []).append(item)
    goal = (turn.target_cell.column, turn.target_cell.row)
    for row in reversed(range(ROWS)):
        cells = []
        for column in range(COLUMNS):
            names = " under ".join(str(item.type) for item in stacks.get((column, row), []))
            here = "YOU" if (column, row) == (START.column, START.row) else ""
            mark = "GOAL" if with_goal and (column, row) == goal else ""
            cells.append(" ".join(filter(None, (names, here, mark))) or "-")
        lines.append(f"  row {row}: " + " | ".join(cells))
    if with_goal:
        lines.append(f"place the {turn.target.type} at GOAL, {_height(turn.target_cell.level, stacks.get(goal, []))}")
    return lines


def _height(level: int, stack: list[PlacedObject]) -> str:
    return "on the floor" if level == 1 else f"on top of the {stack[-1].type}"

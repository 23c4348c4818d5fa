"""Free cells of the room that an instruction fits as a person reads it: each relation holds or does not."""

from arramon_client.world import COLUMNS, ROWS
from arramon_lang.cell_grading import START, Cell, Room, quarter_after, relative
from arramon_lang.meaning import Assembly, Thing, Where

BEYOND: tuple[Cell, ...] = ((0, 1), (1, 0), (0, -1), (-1, 0))
"""Offset of the cell beyond a wall, by the wall's quarter."""


def fitting_cells(meaning: Assembly, target: Cell, room: Room) -> tuple[Cell, ...]:
    """Return the cells, including the target's, that an instruction may mean to a person on the start tile.

    "Left of" and "right of" a thing are all cells in line with it on that side, and to one's own side all that are not
    behind, unless they are "directly" there. "In front of" and "behind" mean the next cell if the target is the next.
    "Behind and to the left of" means all cells on both sides. Where "on your left" is not in one's own row, what is
    "near" or "left of" a thing may be in another row as well. What is "near" a thing and at a wall may be diagonal to
    the thing.

    Args:
        meaning: with identities of all things that it names ("room/COLUMN,LEVEL,ROW", "wall/LOOK").
        target: (column, row) of the target.
        room: all objects in the room.
    """
    if any(where.relation == "on_top_of" for where in meaning.where):
        return (target,)
    quarter = quarter_after(meaning.turns)
    is_loose = any(_is_loose(where, target, quarter) for where in meaning.where)
    is_by_wall = any(where.things[0].kind == "wall" for where in meaning.where)
    free = [(column, row) for column in range(COLUMNS) for row in range(ROWS)]
    free = [cell for cell in free if cell != START and (cell == target or not room.height(cell))]
    return tuple(
        cell
        for cell in free
        if all(_fits(where, cell, target, room, quarter, is_loose, is_by_wall) for where in meaning.where)
    )


def _is_loose(where: Where, target: Cell, quarter: int) -> bool:
    """Return whether a relation to the agent states its side but not its row; other relations are then as loose."""
    is_side = where.relation in ("left_of", "right_of") and where.things[0].kind == "you"
    return is_side and not where.exactly and relative(target, START, quarter)[1] != 0


def _fits(where: Where, cell: Cell, target: Cell, room: Room, quarter: int, is_loose: bool, is_by_wall: bool) -> bool:
    offsets = [_offset(cell, thing, room, quarter) for thing in where.things]
    right, ahead = offsets[0]
    first = where.things[0].kind
    if where.relation == "between":
        return all(_is_beside(offset) for offset in offsets) and offsets[0] == (-offsets[1][0], -offsets[1][1])
    if first == "wall":
        return _is_beside(offsets[0]) and (right == 0 or ahead == 0)
    if where.relation == "diagonal_to":
        return abs(right) == abs(ahead) == 1
    if where.relation in ("near", "against"):
        is_any = is_loose or (is_by_wall and where.relation == "near" and not where.exactly)
        return _is_beside(offsets[0]) if is_any else abs(right) + abs(ahead) == 1
    own = _offset(target, where.things[0], room, quarter)
    is_next = where.exactly
    if first != "you" and own[0] and own[1]:
        sides = {"left_of": -right, "right_of": right, "behind": ahead, "in_front_of": -ahead}
        return sides[where.relation] >= 1
    if where.relation in ("left_of", "right_of"):
        aside = right if where.relation == "right_of" else -right
        in_line = ahead == 0 or (not is_next and (ahead >= 0 if first == "you" else is_loose))
        return in_line and (aside == 1 if is_next else aside >= 1)
    is_next = is_next or (own[0] == 0 and abs(own[1]) == 1)
    away = ahead if where.relation == "behind" or first == "you" else -ahead
    return right == 0 and (away == 1 if is_next else away >= 1)


def _is_beside(offset: Cell) -> bool:
    return max(map(abs, offset)) == 1


def _offset(cell: Cell, thing: Thing, room: Room, quarter: int) -> Cell:
    """Return a cell's offset to the right of and ahead of a thing; for a wall, of the nearest cell beyond it."""
    if thing.kind == "you":
        return relative(cell, START, quarter)
    if thing.kind == "wall":
        return from_wall(cell, thing, room, quarter)
    column, _, row = map(int, thing.identity.rpartition("/")[2].split(","))
    return relative(cell, (column, row), quarter)


def from_wall(cell: Cell, wall: Thing, room: Room, quarter: int) -> Cell:
    """Return a cell's offset to the right of and ahead of the nearest cell beyond a wall."""
    along = BEYOND[room.walls[wall.look]]
    column = cell[0] if not along[0] else COLUMNS if along[0] > 0 else -1
    row = cell[1] if not along[1] else ROWS if along[1] > 0 else -1
    return relative(cell, (column, row), quarter)

"""The gate for assembly: every object that an instruction names, and every relation, held against the room."""

from collections.abc import Iterator

from lang.meaning import Assembly, Thing, Where
from lang.room import COLUMNS, ROWS, START, Cell, Room, Standing, quarter_after, relative
from server.dataset.instructions.gate import faults_of_names

BEYOND: tuple[Cell, ...] = ((0, 1), (1, 0), (0, -1), (-1, 0))
"""Offset of the cell beyond a wall, by the wall's quarter."""


def faults_of_assembly(meaning: Assembly, cell: Cell, room: Room) -> tuple[str, ...]:
    """Return what an instruction says that is not so; nothing if all of it is true.

    Args:
        meaning: with the identity of everything that it names ("room/COLUMN,LEVEL,ROW", "wall/LOOK").
        cell: (column, row) where the object is to be placed.
        room: all objects in the room.
    """
    named = Assembly(meaning.turns, Thing(""), meaning.where)
    return (*faults_of_names(named), *_faults(meaning, cell, room))


def _faults(meaning: Assembly, cell: Cell, room: Room) -> Iterator[str]:
    quarter = quarter_after(meaning.turns)
    for where in meaning.where:
        offsets = []
        for thing in where.things:
            if thing.kind == "you":
                offsets.append(relative(cell, START, quarter))
            elif thing.kind == "wall":
                offsets.append(_from_wall(cell, thing, room, quarter))
            else:
                item = next((i for i in room.things if _identity(i) == thing.identity), None)
                if item is None or not _fits(thing, item):
                    yield f"{thing.identity} is no {thing.look} {thing.colour} {thing.kind}"
                    continue
                if not thing.where and sum(_fits(thing, other) for other in room.things) > 1:
                    yield f"{thing.look} {thing.colour} {thing.kind} may be another than {thing.identity}"
                offsets.append(relative(cell, item.cell, quarter))
        if len(offsets) == len(where.things) and not _holds(where, offsets):
            yield f"the cell is not {where.relation} {where.things[0].identity or 'you'}"


def _from_wall(cell: Cell, wall: Thing, room: Room, quarter: int) -> Cell:
    """Return a cell's offset from the nearest place beyond a wall, to the right of it and ahead of it."""
    along = BEYOND[room.walls[wall.look]]
    column = cell[0] if not along[0] else COLUMNS if along[0] > 0 else -1
    row = cell[1] if not along[1] else ROWS if along[1] > 0 else -1
    return relative(cell, (column, row), quarter)


def _holds(where: Where, offsets: list[Cell]) -> bool:
    (right, ahead), last = offsets[0], offsets[-1]
    near = max(abs(right), abs(ahead)) <= 1
    return {
        "on_top_of": (right, ahead) == (0, 0), "left_of": right < 0, "right_of": right > 0, "in_front_of": ahead < 0,
        "behind": ahead > 0, "near": near, "against": near, "diagonal_to": abs(right) == abs(ahead) > 0,
        "between": (right, ahead) == (-last[0], -last[1]),
    }[where.relation] or (where.relation == "in_front_of" and where.things[0].kind == "you" and ahead > 0)  # fmt: skip


def _fits(thing: Thing, item: Standing) -> bool:
    return thing.kind in ("", item.kind) and thing.colour in ("", item.colour) and thing.look in ("", item.look)


def _identity(item: Standing) -> str:
    return f"room/{item.column},{item.level},{item.row}"

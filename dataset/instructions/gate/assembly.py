"""Gate checks of assembly instructions: names and relations against the objects in the room."""

from collections.abc import Iterator

from arramon_dataset.instructions.assembly.cells import fitting_cells, from_wall
from arramon_dataset.instructions.gate.texts import faults_of_names
from arramon_lang.cell_grading import START, Cell, Room, RoomObject, quarter_after, relative
from arramon_lang.meaning import Assembly, Thing, Where


def faults_of_assembly(meaning: Assembly, cell: Cell, room: Room) -> tuple[str, ...]:
    """Return the false statements of an instruction, or that it fits other free cells too; () if there is no fault.

    Args:
        meaning: with identities of all things that it names ("room/COLUMN,LEVEL,ROW", "wall/LOOK").
        cell: (column, row) of the target.
        room: all objects in the room.
    """
    named = Assembly(meaning.turns, Thing(""), meaning.where)
    faults = (*faults_of_names(named), *_faults(meaning, cell, room))
    if not faults and (others := [other for other in fitting_cells(meaning, cell, room) if other != cell]):
        return (f"the cell may be taken for {', '.join(map(str, others))}",)
    return faults


def _faults(meaning: Assembly, cell: Cell, room: Room) -> Iterator[str]:
    quarter = quarter_after(meaning.turns)
    named = {thing.identity for where in meaning.where for thing in where.things}
    for nested in (inner for where in meaning.where for thing in where.things for inner in thing.where):
        yield from (f"{each.identity} locates two things at once" for each in nested.things if each.identity in named)
    for where in meaning.where:
        offsets = []
        for thing in where.things:
            if thing.kind == "you":
                offsets.append(relative(cell, START, quarter))
            elif thing.kind == "wall":
                offsets.append(from_wall(cell, thing, room, quarter))
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


def _holds(where: Where, offsets: list[Cell]) -> bool:
    (right, ahead), last = offsets[0], offsets[-1]
    near = max(abs(right), abs(ahead)) <= 1
    return {
        "on_top_of": (right, ahead) == (0, 0), "left_of": right < 0, "right_of": right > 0, "in_front_of": ahead < 0,
        "behind": ahead > 0, "near": near, "against": near, "diagonal_to": abs(right) == abs(ahead) > 0,
        "between": (right, ahead) == (-last[0], -last[1]),
    }[where.relation] or (where.relation == "in_front_of" and where.things[0].kind == "you" and ahead > 0)  # fmt: skip


def _fits(thing: Thing, item: RoomObject) -> bool:
    return thing.kind in ("", item.kind) and thing.colour in ("", item.colour) and thing.look in ("", item.look)


def _identity(item: RoomObject) -> str:
    return f"room/{item.column},{item.level},{item.row}"

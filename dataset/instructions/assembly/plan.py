"""Planning of assembly instructions: turns and relations that identify the target's cell and no other.

The semantics of relations is that of `arramon_lang.cell_grading`, shared with followers. Only objects that the camera
shows from the start tile are mentioned; the plan must hold with and without the hidden ones.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from arramon_client.world import COLUMNS, ROWS
from arramon_dataset.instructions.assembly.cells import fitting_cells
from arramon_dataset.instructions.assembly.namer import ObjectNamer
from arramon_dataset.instructions.assembly.visible_objects import visible_room, whole_room
from arramon_lang.cell_grading import RoomObject, find_cell, quarter_after, relative
from arramon_lang.meaning import Assembly, Thing, Where
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.room import START, RoomPosition
from arramon_server.sim.rules import PlacedObject

TRIES = 60
"""Maximum number of plans drawn before planning fails."""

MIN_LEAD = 1.5
"""Minimum ratio of the fits of the target's cell and of any other."""

MAX_RELATIONS = 2
"""Maximum number of relations in one instruction."""

ONE_RELATION = 0.35
"""Probability that plans with a single relation are tried first: most people give one."""

TRIES_PER_RELATION = 15
"""Number of plans drawn before one with a further relation is accepted."""

PLAIN_TRIES = 45
"""Number of plans drawn before one is accepted that is hard to say and to read: people seldom write these."""

EXTRA_RELATION = 0.08
"""Probability of an unnecessary relation."""

EXTRA_RELATION_ON_TOP = 0.22
"""The same if the target goes on top of another object: of that one to a wall or to the reader, in ON_TOP_WEIGHTS."""

ON_TOP_WEIGHTS = {
    "against wall": 5.0, "near wall": 5.0, "in_front_of you": 4.0, "far": 4.0, "left_of you": 1.2,
    "right_of you": 1.2, "your side": 1.2,
}  # fmt: skip
"""Relative frequency with which people add each relation of the object on which the target goes."""

EXACTLY, EXACTLY_ASIDE, EXACTLY_YOU = 0.03, 0.01, 0.4
"""Probabilities of "directly" with a relation to an adjacent cell, with "left of" and "right of", which otherwise fit
farther cells, and with a relation to the agent."""

WEIGHTS = {
    "left_of": 46.0, "right_of": 25.0, "in_front_of": 0.3, "behind": 26.0, "between": 2.0, "near": 0.3,
    "diagonal_to": 0.04, "against wall": 4.2, "near wall": 3.4, "in_front_of you": 4.0, "left_of you": 1.0,
    "right_of you": 1.0, "far": 0.6, "your side": 0.5,
}  # fmt: skip
"""Relative frequency with which people choose each relation where it holds. "far" is one of the first four to a cell
that is not adjacent; "your side" is "on your left" for any cell there."""

WALL_FIRST = 0.45
"""Probability that a relation to a wall precedes another one."""

SECOND_WALL = 0.2
"""Probability that a second wall is considered where one has been named."""

TURN_FIRST = ((0.92, 0.9), (0.85, 0.8), (0.25, 0.12), (0.04, 0.01))
"""Probability that an instruction starts with a turn, for a target on the floor and one on top, by the cell's
direction: beside the start tile, beyond 60 degrees, about 45, less. As measured in the release."""


@dataclass(frozen=True, slots=True)
class _Option:
    """Relations that hold for the target's cell, with their landmarks still unnamed."""

    name: str
    relations: tuple[str, ...]
    landmarks: tuple[RoomObject | Thing, ...]


def plan_assembly(
    target_type: ObjectType, target_cell: RoomPosition, room: tuple[PlacedObject, ...], random: Random
) -> Assembly | None:
    """Return a meaning that identifies the target's cell and clearly no other, or None if none was found.

    Args:
        target_type: type of the object to place.
        target_cell: where it is to be placed: [column, level, row].
        room: objects in the room when the phase begins; in turn 2 including the object placed in turn 1.
        random: draws all choices.

    Raises:
        ValueError: if the target's level is not one above the highest object in its cell.
    """
    whole = whole_room(room)
    cell = (target_cell.column, target_cell.row)
    if whole.height(cell) + 1 != target_cell.level:
        raise ValueError(
            f"the target's level is {target_cell.level} in column {cell[0]}, row {cell[1]}; "
            f"expected one above the {whole.height(cell)} objects there"
        )
    seen = visible_room(room)
    most = 1 if random.random() < ONE_RELATION else 2
    for number in range(TRIES):
        turns = _draw_turns(target_cell, random)
        namer = ObjectNamer(seen, whole, target_type, quarter_after(turns))
        meaning = _draw(turns, target_cell, namer, random)
        if meaning is None or len(meaning.where) > most + number // TRIES_PER_RELATION:
            continue
        if number >= PLAIN_TRIES or _is_plain(meaning):
            return meaning
    return None


def _is_plain(meaning: Assembly) -> bool:
    """Return whether a meaning is easily said.

    That is without a diagonal, without a landmark told by its neighbour beside another relation, and with no side told
    twice: "to the right of the bucket and to the right of the bowl".
    """
    is_nested = any(thing.where for where in meaning.where for thing in where.things)
    relations = [where.relation for where in meaning.where]
    is_doubled = max(relations.count("left_of"), relations.count("right_of")) > 1
    return "diagonal_to" not in relations and not (is_nested and len(relations) > 1) and not is_doubled


def _draw_turns(cell: RoomPosition, random: Random) -> tuple[str, ...]:
    across, ahead = cell.column - START.column, cell.row - START.row
    aside = 0 if ahead == 0 else 1 if abs(across) > 1.5 * ahead else 2 if abs(across) >= ahead else 3
    share = TURN_FIRST[aside][0 if cell.level == 1 else 1]
    if across == 0 or random.random() >= share:
        return ()
    return ("right",) if across > 0 else ("left",)


def _draw(turns: tuple[str, ...], cell: RoomPosition, namer: ObjectNamer, random: Random) -> Assembly | None:
    """Return one random plan, or None if it does not identify the cell."""
    thing = namer.name_target(random)
    where: tuple[Where, ...] = ()
    options = list(_options(cell, namer))
    if cell.level > 1:
        base = next(
            (i for i in namer.seen.things if (i.column, i.level, i.row) == (cell[0], cell[1] - 1, cell[2])), None
        )
        name = base and namer.name(base, random)
        if not name:
            return None
        whole = Assembly(turns, thing, (Where("on_top_of", (name,)), *_place_of_base(options, random)))
        return whole if _is_unambiguous(whole, cell, namer) else None
    is_enough, more = False, EXTRA_RELATION
    while not is_enough or random.random() < more:
        if is_enough:  # Rare relations are not added without need.
            options = [option for option in options if WEIGHTS[option.name] >= 1.0]
        option = _choose(options, random)
        if option is None or len(where) >= MAX_RELATIONS:
            break
        added = _name_landmarks(option, namer, random)
        if added is None or len(where) + len(added) > MAX_RELATIONS:
            continue
        options = [other for other in options if _goes_with(other, option, random)]
        where += added
        is_enough, more = _is_unambiguous(Assembly(turns, thing, where), cell, namer), more / 2
    if not where or not _is_unambiguous(Assembly(turns, thing, where), cell, namer):
        return None
    simple = _simplified(where)
    if simple != where and _is_unambiguous(Assembly(turns, thing, simple), cell, namer):
        where = simple
    # "Against the wall, in front of you" would say that the wall is in front of the reader.
    is_wall_first = random.random() < WALL_FIRST and all(each.things[0].kind != "you" for each in where)
    order = {"wall": -1 if is_wall_first else 1, "you": 0.5}
    where = tuple(sorted(where, key=lambda each: order.get(each.things[0].kind, 0)))
    return Assembly(turns, thing, where)


def _place_of_base(options: list[_Option], random: Random) -> tuple[Where, ...]:
    """Return a relation to a wall or to the reader of the object on which the target goes, by chance; () for none."""
    fixed = [option for option in options if all(isinstance(mark, Thing) for mark in option.landmarks)]
    fixed = [option for option in fixed if option.name in ON_TOP_WEIGHTS]
    if not fixed or random.random() > EXTRA_RELATION_ON_TOP:
        return ()
    (option,) = random.choices(fixed, [ON_TOP_WEIGHTS[option.name] for option in fixed])
    things = tuple(mark for mark in option.landmarks if isinstance(mark, Thing))
    return tuple(Where(relation, things) for relation in option.relations)


def _goes_with(option: _Option, chosen: _Option, random: Random) -> bool:
    """Return whether an option may follow a chosen one: two walls are for a target against both, and by chance."""
    if not (option.name.endswith(" wall") and chosen.name.endswith(" wall")):
        return True
    return option.name == chosen.name == "against wall" and random.random() < SECOND_WALL


def _simplified(where: tuple[Where, ...]) -> tuple[Where, ...]:
    """Return two relations as the one that people give: "between" for two things opposite each other."""
    if len(where) != 2 or any(each.exactly or len(each.things) > 1 for each in where):
        return where
    (one, other), things = where, tuple(thing for each in where for thing in each.things)
    if any(thing.kind in ("you", "wall") for thing in things):
        return where
    if {one.relation, other.relation} in ({"left_of", "right_of"}, {"in_front_of", "behind"}):
        return (Where("between", things),)
    return where


def _is_unambiguous(meaning: Assembly, cell: RoomPosition, namer: ObjectNamer) -> bool:
    """Return whether only the target's cell fits clearly, in the whole room and in its visible part."""
    if len(meaning.where) == 1 and meaning.where[0].things[0].kind == "wall":
        return False  # A wall has several cells along it, even if all but one are occupied.
    for room in (namer.seen, namer.whole):
        found, lead = find_cell(meaning, room)
        target = cell.column, cell.row
        if found != target or lead < MIN_LEAD or len(fitting_cells(meaning, target, room)) > 1:
            return False
    return True


def _choose(options: list[_Option], random: Random) -> _Option | None:
    """Draw an option, and remove it and all others with the same landmarks from the list; None if it is empty."""
    if not options:
        return None
    # Several objects may be in the same relation, such as "near", so the relation is drawn first.
    kinds = sorted({option.name for option in options})
    kind = random.choices(kinds, [WEIGHTS[name] for name in kinds])[0]
    chosen = random.choice([option for option in options if option.name == kind])
    options[:] = [option for option in options if not set(option.landmarks) & set(chosen.landmarks)]
    return chosen


def _name_landmarks(option: _Option, namer: ObjectNamer, random: Random) -> tuple[Where, ...] | None:
    """Return the option's relations with names for their landmarks, or None if one has no unique name."""
    things = [mark if isinstance(mark, Thing) else namer.name(mark, random) for mark in option.landmarks]
    named = tuple(thing for thing in things if thing is not None)
    if len(named) < len(things):
        return None
    is_you = any(thing.kind == "you" for thing in named)
    is_next = option.name.removesuffix(" you") in ("left_of", "right_of", "in_front_of", "behind")
    is_aside = option.name in ("left_of", "right_of")
    exactly = is_next and random.random() < (EXACTLY_YOU if is_you else EXACTLY_ASIDE if is_aside else EXACTLY)
    return tuple(Where(relation, named, exactly) for relation in option.relations)


def _options(cell: RoomPosition, namer: ObjectNamer) -> Iterator[_Option]:
    """Yield all relations that hold for the cell in the agent's viewing direction."""
    here = (cell.column, cell.row)
    in_front = [item for item in namer.seen.things if _is_in_front(item, namer.quarter) and item.cell != here]
    for item in in_front:
        offset = relative(here, item.cell, namer.quarter)
        yield from _beside(offset, item) if max(map(abs, offset)) == 1 else _far(offset, item)
    marks: list[tuple[tuple[int, int], RoomObject | Thing]] = [
        (relative(here, i.cell, namer.quarter), i) for i in in_front
    ]
    for wall, offset in _walls_beside(here, namer):
        yield _Option("against wall", ("against",), (wall,))
        yield _Option("near wall", ("near",), (wall,))
        marks.append((offset, wall))
    for index, (offset, mark) in enumerate(marks):
        for other_offset, other in marks[index + 1 :]:
            is_opposite = max(map(abs, offset)) == 1 and (-offset[0], -offset[1]) == other_offset
            if is_opposite and (isinstance(mark, RoomObject) or isinstance(other, RoomObject)):
                yield _Option("between", ("between",), (mark, other))
    across, ahead = relative(here, (START.column, START.row), namer.quarter)
    relation = {(0, 1): "in_front_of", (-1, 0): "left_of", (1, 0): "right_of"}.get((across, ahead))
    if relation:
        yield _Option(f"{relation} you", (relation,), (Thing("you"),))
    elif across == 0 and ahead > 1:
        yield _Option("far", ("in_front_of",), (Thing("you"),))
    elif ahead > 0:
        yield _Option("your side", ("left_of" if across < 0 else "right_of",), (Thing("you"),))


def _beside(offset: tuple[int, int], item: RoomObject) -> Iterator[_Option]:
    """Yield the relations of a cell to an adjacent item, given the cell's offset to the right of it and ahead of it."""
    across, ahead = offset
    side = {-1: "left_of", 1: "right_of"}.get(across, "")
    depth = {-1: "in_front_of", 1: "behind"}.get(ahead, "")
    if (side and ahead == 0) or (depth and across == 0):
        relation = side or depth
        yield _Option(relation, (relation,), (item,))
        yield _Option("near", ("near",), (item,))
    elif side and depth:
        yield _Option("diagonal_to", ("diagonal_to",), (item,))


def _far(offset: tuple[int, int], item: RoomObject) -> Iterator[_Option]:
    """Yield the relations of a cell to an item in line with it, farther away."""
    across, ahead = offset
    if not across or not ahead:
        depth = "in_front_of" if ahead < 0 else "behind"
        yield _Option("far", (depth if ahead else "left_of" if across < 0 else "right_of",), (item,))


def _walls_beside(cell: tuple[int, int], namer: ObjectNamer) -> Iterator[tuple[Thing, tuple[int, int]]]:
    """Yield the walls adjacent to a cell, with the cell's offset to the right of and ahead of each."""
    column, row = cell
    beyond = ((column, row + 1), (column + 1, row), (column, row - 1), (column - 1, row))
    for look, quarter in namer.seen.walls.items():
        place = beyond[quarter]
        if not (0 <= place[0] < COLUMNS and 0 <= place[1] < ROWS):
            yield Thing("wall", look=look, identity=f"wall/{look}"), relative(cell, place, namer.quarter)


def _is_in_front(item: RoomObject, quarter: int) -> bool:
    """Return whether an item is in front of an agent on the start tile that looks in that quarter."""
    across, ahead = relative(item.cell, (START.column, START.row), quarter)
    return abs(across) <= 2 * ahead

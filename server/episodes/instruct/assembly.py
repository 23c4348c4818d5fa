"""Plans what an assembly instruction says: turns and relations that lead to the target's cell and to no other.

The relations' semantics is `lang.placing`'s, which whoever follows the instruction shares. Only what the camera sees
from the start tile is mentioned; the plan must hold with and without what is hidden.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from lang.meaning import Assembly, Thing, Where
from lang.placing import COLUMNS, ROWS, Standing, find_cell, quarter_after, relative
from server.episodes.instruct.assembly_names import Names
from server.episodes.instruct.assembly_sight import seen_room, whole_room
from server.sim.catalogue import ObjectType
from server.sim.room import START, Placement
from server.sim.rules import PlacedObject

TRIES = 60
"""Plans drawn before it is given up."""

CLEARLY = 1.5
"""How much better the target's cell must fit than any other."""

MOST = 3
"""Relations in one instruction."""

MORE = 0.2
"""How often another relation is said though it needs none."""

MORE_ON_TOP = 0.12
"""The same where the object goes on top of something."""

EXACTLY = 0.15
"""How often "directly" is said of the next cell; of the cell before the agent itself `EXACTLY_YOU`."""

EXACTLY_YOU = 0.6

WEIGHTS = {
    "left_of": 12.0, "right_of": 7.5, "in_front_of": 7.0, "behind": 26.0, "between": 9.0, "near": 3.0,
    "diagonal_to": 0.25, "against wall": 9.0, "near wall": 3.5, "in_front_of you": 18.0, "left_of you": 3.0,
    "right_of you": 3.0, "askew": 0.4, "far": 0.6, "your side": 1.0,
}  # fmt: skip
"""How readily people choose each relation where it holds; "askew" is two at once, "behind and to the left of";
"far" is one of the first four with free cells between: with a wall it may settle what nothing nearer does;
"your side" is "on your left" said of any cell there."""

TURNED = ((0.92, 0.9), (0.85, 0.8), (0.25, 0.12), (0.04, 0.01))
"""How often a turn is said first, for a target on the floor and one on top, by how far aside the cell lies: beside the
start tile, beyond 60 degrees, about 45, less. As measured in the release."""


@dataclass(frozen=True, slots=True)
class _Option:
    """Relations that hold of the target's cell, before their landmarks have names."""

    name: str
    relations: tuple[str, ...]
    landmarks: tuple[Standing | Thing, ...]


def plan_assembly(
    target_type: ObjectType, target_cell: Placement, room: tuple[PlacedObject, ...], random: Random
) -> Assembly | None:
    """A meaning that leads to the target's cell, and clearly to no other; None where none was found.

    Args:
        target_type: what is to be placed.
        target_cell: where it belongs: [column, level, row].
        room: what stands there when the phase begins, in turn 2 with the object placed in turn 1.
        random: draws all that may differ.

    Raises:
        ValueError: if the target's level is not the one above what stands in its cell.
    """
    whole = whole_room(room)
    cell = (target_cell.column, target_cell.row)
    if whole.height(cell) + 1 != target_cell.level:
        raise ValueError(
            f"the target belongs on level {target_cell.level} of column {cell[0]}, row {cell[1]}, "
            f"where {whole.height(cell)} objects stand; expected as many less one"
        )
    seen = seen_room(room)
    for _ in range(TRIES):
        turns = _draw_turns(target_cell, random)
        names = Names(seen, whole, target_type, quarter_after(turns))
        meaning = _draw(turns, target_cell, names, random)
        if meaning is not None:
            return meaning
    return None


def _draw_turns(cell: Placement, random: Random) -> tuple[str, ...]:
    across, ahead = cell.column - START.column, cell.row - START.row
    aside = 0 if ahead == 0 else 1 if abs(across) > 1.5 * ahead else 2 if abs(across) >= ahead else 3
    share = TURNED[aside][0 if cell.level == 1 else 1]
    if across == 0 or random.random() >= share:
        return ()
    return ("right",) if across > 0 else ("left",)


def _draw(turns: tuple[str, ...], cell: Placement, names: Names, random: Random) -> Assembly | None:
    """One plan, if it leads there."""
    thing = names.of_target(random)
    where: tuple[Where, ...] = ()
    options = list(_options(cell, names))
    more = MORE
    if cell.level > 1:
        base = next(
            (i for i in names.seen.things if (i.column, i.level, i.row) == (cell[0], cell[1] - 1, cell[2])), None
        )
        name = base and names.of(base, random)
        if not name:
            return None
        where, more = (Where("on_top_of", (name,)),), MORE_ON_TOP
    is_enough = bool(where) and _leads(Assembly(turns, thing, where), cell, names)
    while not is_enough or random.random() < more:
        if is_enough:  # what is rarely said is not added without need
            options = [option for option in options if WEIGHTS[option.name] >= 1.0]
        option = _choose(options, random)
        if option is None or len(where) >= MOST:
            break
        added = _put(option, names, random)
        if added is None or len(where) + len(added) > MOST:
            continue
        where += added
        is_enough, more = _leads(Assembly(turns, thing, where), cell, names), more / 2
    if not where or not _leads(Assembly(turns, thing, where), cell, names):
        return None
    return Assembly(turns, thing, where)


def _leads(meaning: Assembly, cell: Placement, names: Names) -> bool:
    """Whether the target's cell is clearly the best, whether or not one sees all there is."""
    if len(meaning.where) == 1 and meaning.where[0].things[0].kind == "wall":
        return False  # along a wall there are several cells, even where something stands on the others
    for room in (names.seen, names.whole):
        found, lead = find_cell(meaning, room)
        if found != (cell.column, cell.row) or lead < CLEARLY:
            return False
    return True


def _choose(options: list[_Option], random: Random) -> _Option | None:
    """Draws one and takes it, and all others of the same landmarks, out of the list; None where there is none."""
    if not options:
        return None
    # Several things may stand in one relation, such as to be near; the relation is chosen first.
    kinds = sorted({option.name for option in options})
    kind = random.choices(kinds, [WEIGHTS[name] for name in kinds])[0]
    chosen = random.choice([option for option in options if option.name == kind])
    options[:] = [option for option in options if not set(option.landmarks) & set(chosen.landmarks)]
    return chosen


def _put(option: _Option, names: Names, random: Random) -> tuple[Where, ...] | None:
    """An option with its landmarks named; None where one has no name of its own."""
    things = [mark if isinstance(mark, Thing) else names.of(mark, random) for mark in option.landmarks]
    named = tuple(thing for thing in things if thing is not None)
    if len(named) < len(things):
        return None
    is_you = any(thing.kind == "you" for thing in named)
    is_next = option.name.removesuffix(" you") in ("left_of", "right_of", "in_front_of", "behind")
    exactly = is_next and random.random() < (EXACTLY_YOU if is_you else EXACTLY)
    return tuple(Where(relation, named, exactly) for relation in option.relations)


def _options(cell: Placement, names: Names) -> Iterator[_Option]:
    """All that can be said of the cell, as seen where the agent looks."""
    here = (cell.column, cell.row)
    before = [item for item in names.seen.things if _is_before(item, names.quarter) and item.cell != here]
    for item in before:
        offset = relative(here, item.cell, names.quarter)
        yield from _beside(offset, item) if max(map(abs, offset)) == 1 else _far(offset, item)
    marks: list[tuple[tuple[int, int], Standing | Thing]] = [(relative(here, i.cell, names.quarter), i) for i in before]
    for wall, offset in _walls_beside(here, names):
        yield _Option("against wall", ("against",), (wall,))
        yield _Option("near wall", ("near",), (wall,))
        marks.append((offset, wall))
    for index, (offset, mark) in enumerate(marks):
        for other_offset, other in marks[index + 1 :]:
            is_opposite = max(map(abs, offset)) == 1 and (-offset[0], -offset[1]) == other_offset
            if is_opposite and (isinstance(mark, Standing) or isinstance(other, Standing)):
                yield _Option("between", ("between",), (mark, other))
    across, ahead = relative(here, (START.column, START.row), names.quarter)
    relation = {(0, 1): "in_front_of", (-1, 0): "left_of", (1, 0): "right_of"}.get((across, ahead))
    if relation:
        yield _Option(f"{relation} you", (relation,), (Thing("you"),))
    elif across == 0 and ahead > 1:
        yield _Option("far", ("in_front_of",), (Thing("you"),))
    elif ahead > 0:
        yield _Option("your side", ("left_of" if across < 0 else "right_of",), (Thing("you"),))


def _beside(offset: tuple[int, int], item: Standing) -> Iterator[_Option]:
    """What can be said of a cell so far to the right of and ahead of an item."""
    across, ahead = offset
    side = {-1: "left_of", 1: "right_of"}.get(across, "")
    depth = {-1: "in_front_of", 1: "behind"}.get(ahead, "")
    if (side and ahead == 0) or (depth and across == 0):
        relation = side or depth
        yield _Option(relation, (relation,), (item,))
        yield _Option("near", ("near",), (item,))
    elif side and depth:
        yield _Option("diagonal_to", ("diagonal_to",), (item,))
        yield _Option("askew", (depth, side), (item,))


def _far(offset: tuple[int, int], item: Standing) -> Iterator[_Option]:
    """What can be said of a cell in line with an item further off."""
    across, ahead = offset
    if not across or not ahead:
        depth = "in_front_of" if ahead < 0 else "behind"
        yield _Option("far", (depth if ahead else "left_of" if across < 0 else "right_of",), (item,))


def _walls_beside(cell: tuple[int, int], names: Names) -> Iterator[tuple[Thing, tuple[int, int]]]:
    """The walls next to a cell, and how far it is to the right of and ahead of each."""
    column, row = cell
    beyond = ((column, row + 1), (column + 1, row), (column, row - 1), (column - 1, row))
    for look, quarter in names.seen.walls.items():
        place = beyond[quarter]
        if not (0 <= place[0] < COLUMNS and 0 <= place[1] < ROWS):
            yield Thing("wall", look=look), relative(cell, place, names.quarter)


def _is_before(item: Standing, quarter: int) -> bool:
    """Whether an agent that looks that way has it before itself."""
    across, ahead = relative(item.cell, (START.column, START.row), quarter)
    return abs(across) <= 2 * ahead

"""What an assembly's relations mean on the room's floor: one semantics for who plans an instruction and who follows it.

All relations are those an agent sees from the start tile, after the turns that are said: "behind" is one cell further
from it along its line of sight, "left of" one cell to its left, and so on, for every thing alike, wherever it stands.
So "turn right and place it left of the mug" means the cell with one row more than the mug's. (The release's second
turns say so, where they name the object placed in the first: after a turn to the right, left is +row in all cases.)
The paper calls a relation to the agent itself or a turn egocentric, one between things allocentric; here both are seen
with the same eyes. Of several cells that a word may mean, the nearest is meant: relations are graded, and what fits all
of them best is where the object belongs. It stands on the floor unless it is said to be on top of something.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from lang.going import DEGREES
from lang.meaning import Assembly, Thing, Where

COLUMNS, ROWS = 5, 4
START = (2, 0)
"""(column, row) of the agent, which looks towards +row before it turns."""

Cell = tuple[int, int]
"""(column, row)."""

MISSED = {"kind": 0.05, "colour": 0.15, "look": 0.3}
"""What a word that is not true of a thing leaves of its chance to be the one that is meant: people confuse patterns
sooner than kinds."""

NO = 0.01
"""How well a cell fits a relation in which it does not stand: little, but a misread relation must not rule it out."""

OCCUPIED = 0.05
"""Chance of a cell where something stands, when nothing is said of "on top"."""

OUT_OF_VIEW = 0.6
"""Chance of a thing that the agent does not have before it after turns that were said."""

BESIDE_EYES = 0.6
"""How well a cell ahead but to one side fits "to your left"."""

EDGE = 0.7
"""Chance of column 0: the original never puts anything there, nor do generated episodes."""


@dataclass(frozen=True, slots=True)
class Standing:
    """An object that stands in the room; `level` 1 is on the floor."""

    kind: str
    colour: str
    look: str
    column: int
    row: int
    level: int = 1

    @property
    def cell(self) -> Cell:
        """Where it stands."""
        return self.column, self.row


@dataclass(frozen=True, slots=True)
class Room:
    """What stands in the room and which wall is where.

    Attributes:
        things: all objects known to stand there.
        walls: for the look of each wall known, the quarter in which it stands, turned clockwise from +row: 0 beyond the
            last row, 1 beyond the last column, 2 before row 0, 3 before column 0.
    """

    things: tuple[Standing, ...]
    walls: Mapping[str, int]

    def height(self, cell: Cell) -> int:
        """How many objects stand on a cell, one upon the other."""
        return max((thing.level for thing in self.things if thing.cell == cell), default=0)


Landmark = Standing | int | None
"""What a relation is to: an object, the wall in a quarter, or None, the agent."""


def quarter_after(turns: tuple[str, ...]) -> int:
    """Where the agent looks after the turns: quarters clockwise from +row, to the nearest."""
    return round(sum(DEGREES[turn] for turn in turns) / 90) % 4


def find_cell(meaning: Assembly, room: Room) -> tuple[Cell, float]:
    """Where the object belongs, and by what factor this cell fits better than the next (at least 1; inf for no next).

    Cells that fit equally well: the nearest to the start tile, then the first in column and row.
    """
    weights = weigh_cells(meaning, room)
    first, second = sorted(weights, key=lambda cell: (-weights[cell], _distance(cell, START), cell))[:2]
    return first, weights[first] / weights[second] if weights[second] else math.inf


def is_all_there(meaning: Assembly, room: Room) -> bool:
    """Whether for every thing named there is one of whose name every word is true."""
    return all(_is_there(thing, room) for where in meaning.where for thing in where.things)


def _is_there(thing: Thing, room: Room) -> bool:
    if thing.kind == "wall":
        return not thing.look or thing.look in room.walls
    names = [{"kind": item.kind, "colour": item.colour, "look": item.look} for item in room.things]
    others = (other for where in thing.where for other in where.things)
    return (thing.kind == "you" or any(_matching(thing, **words) == 1.0 for words in names)) and all(
        _is_there(other, room) for other in others
    )


def weigh_cells(meaning: Assembly, room: Room) -> dict[Cell, float]:
    """How well each cell but the start tile fits all that is said, from 0 to 1."""
    quarter = quarter_after(meaning.turns)
    landmarks = [_landmarks(where, room, quarter, is_told=bool(meaning.turns)) for where in meaning.where]
    is_on_top = any(where.relation == "on_top_of" for where in meaning.where)
    weights: dict[Cell, float] = {}
    for cell in ((column, row) for column in range(COLUMNS) for row in range(ROWS)):
        if cell == START:
            continue
        height = room.height(cell)
        weight = OCCUPIED if height and not is_on_top else 1.0
        ahead = relative(cell, START, quarter)[1]
        weight *= (1.0 if ahead > 0 else 0.85 if ahead == 0 else 0.6) * (1.0 if cell[0] else EDGE)
        for where, found in zip(meaning.where, landmarks, strict=True):
            weight *= max(
                (w * grade_relation(where, cell, height + 1, marks, quarter) for w, marks in found), default=1.0
            )
        weights[cell] = weight
    return weights


def weigh_things(thing: Thing, room: Room, quarter: int, *, is_told: bool) -> list[tuple[float, Landmark]]:
    """What a name may mean, with the chance of each, from 0 to 1; nothing where there is no such kind of thing at all.

    Args:
        thing: the name.
        room: what there is.
        quarter: where the agent looks.
        is_told: whether it was told to look there: then what is named is rather before it.
    """
    if thing.kind == "you":
        return [(1.0, None)]
    if thing.kind == "wall":
        weights: list[tuple[float, Landmark]] = [
            (_matching(thing, look=look) * (1.0 if thing.look or q == quarter else 0.5), q)
            for look, q in room.walls.items()
        ]
        return _likely(weights)
    graded: list[tuple[float, Standing]] = []
    for item in room.things:
        weight = _matching(thing, kind=item.kind, colour=item.colour, look=item.look)
        for where in thing.where:
            others = Room(tuple(other for other in room.things if other != item), room.walls)
            found = _landmarks(where, others, quarter, is_told=False)
            weight *= max(
                (w * grade_relation(where, item.cell, item.level, marks, quarter) for w, marks in found), default=1.0
            )
        across, ahead = relative(item.cell, START, quarter)
        if is_told and abs(across) > 2 * ahead:  # beyond 63 degrees from where it looks
            weight *= OUT_OF_VIEW
        graded.append((weight, item))
    return _likely(_counted(thing.which, graded))


def _matching(thing: Thing, **words: str) -> float:
    """The chance that a thing with such words is meant, by its name alone."""
    weight = 1.0
    for attribute, word in words.items():
        said = getattr(thing, attribute)
        if said and said != word:
            weight *= MISSED[attribute]
    return weight


def _counted(which: str, graded: list[tuple[float, Standing]]) -> list[tuple[float, Landmark]]:
    """With "first", "last" and the like taken among those that fit best, counted from the agent."""
    if not which or not graded:
        return list(graded)
    most = max(weight for weight, _ in graded)
    fitting = sorted((item for weight, item in graded if weight > most / 2), key=lambda i: _distance(i.cell, START))
    place = {"second": 1, "last": -1}.get(which, 0)
    chosen = fitting[place if place < len(fitting) else -1]
    return [(weight if item == chosen else weight * 0.3, item) for weight, item in graded]


def _likely(weights: list[tuple[float, Landmark]]) -> list[tuple[float, Landmark]]:
    """Without those that hardly come into question beside the likeliest."""
    most = max((weight for weight, _ in weights), default=0.0)
    return [(weight, landmark) for weight, landmark in weights if weight > 0.3 * most]


def _landmarks(where: Where, room: Room, quarter: int, *, is_told: bool) -> list[tuple[float, tuple[Landmark, ...]]]:
    """What the things of a relation may mean, together; nothing where one of them is of a kind that is not there."""
    each = [weigh_things(thing, room, quarter, is_told=is_told) for thing in where.things]
    if len(each) == 1:
        return [(weight, (landmark,)) for weight, landmark in each[0]]
    return [(v * w, (one, other)) for v, one in each[0] for w, other in each[1] if one != other]


def grade_relation(where: Where, cell: Cell, level: int, landmarks: tuple[Landmark, ...], quarter: int) -> float:
    """How well what stands at (cell, level) stands in a relation to landmarks, from 0 to 1."""
    if where.relation == "between":
        grade = _grade_between(cell, landmarks)
    elif isinstance(landmarks[0], int):
        grade = {0: 1.0, 1: 0.15}.get(_from_wall(cell, landmarks[0]), 2 * NO)
    elif where.relation == "on_top_of":
        mark = landmarks[0]
        is_above = mark is not None and cell == mark.cell and level > mark.level
        grade = 0.0 if not is_above else 1.0 if mark is not None and level == mark.level + 1 else 0.8
    else:
        mark = landmarks[0]
        across, ahead = relative(cell, START if mark is None else mark.cell, quarter)
        relation = where.relation
        if mark is None and relation in ("in_front_of", "behind"):  # before one's own eyes is the far side
            ahead = -ahead
        grade = _grade_offset(relation, across, ahead)
        if mark is None and relation in ("left_of", "right_of") and ahead > 0 and grade:
            grade = BESIDE_EYES
    return max(grade * grade if where.exactly else grade, NO)


@cache
def _grade_offset(relation: str, across: int, ahead: int) -> float:
    """How well a cell fits a relation to one that it is so many cells to the right of and further ahead than."""
    apart = abs(across) + abs(ahead)
    if relation == "near":
        return {1: 1.0, 2: 0.5 if across and ahead else 0.2}.get(apart, 0.02)
    if relation == "against":
        return {1: 1.0, 2: 0.3 if across and ahead else 0.05}.get(apart, 0.02)
    if relation == "diagonal_to":
        return 0.02 if abs(across) != abs(ahead) else {0: 0.0, 1: 1.0}.get(abs(across), 0.3)
    along, aside = {
        "left_of": (-across, ahead), "right_of": (across, ahead), "in_front_of": (-ahead, across),
        "behind": (ahead, across),
    }[relation]  # fmt: skip
    if along < 1:
        return 0.0
    if aside == 0:
        return {1: 1.0, 2: 0.4, 3: 0.25}.get(along, 0.15)
    return 0.3 if along == abs(aside) == 1 else 0.1


def _grade_between(cell: Cell, landmarks: tuple[Landmark, ...]) -> float:
    """Best is the one cell in the middle of a straight line; a wall's end of the line is right before it."""
    ends = [START if mark is None else mark.cell for mark in landmarks if not isinstance(mark, int)]
    walls = [mark for mark in landmarks if isinstance(mark, int)]
    if not ends:
        return min({0: 1.0, 1: 0.3}.get(_from_wall(cell, wall), NO) for wall in walls)
    one = ends[0]
    other = ends[1] if len(ends) == 2 else _beyond(one, walls[0])
    wide, deep = other[0] - one[0], other[1] - one[1]
    x, y = cell[0] - one[0], cell[1] - one[1]
    if cell in (one, other):
        return 0.0
    square = wide * wide + deep * deep
    share, beside = (x * wide + y * deep) / max(square, 1), abs(x * deep - y * wide)
    if not 0 < share < 1:
        return 0.0
    if beside == 0:
        steps = max(abs(wide), abs(deep))
        return 1.0 if steps == 2 else 0.6 if x * 2 == wide and y * 2 == deep else 0.5
    off = math.hypot(x - wide / 2, y - deep / 2)
    return 0.5 if off < 0.8 else 0.25 if off < 1.2 else 0.05


def _beyond(cell: Cell, wall: int) -> Cell:
    """The place in the wall that is straight before a cell, as if it were one cell more."""
    column, row = cell
    return ((column, ROWS), (COLUMNS, row), (column, -1), (-1, row))[wall]


def _from_wall(cell: Cell, wall: int) -> int:
    """Cells between a cell and a wall."""
    column, row = cell
    return (ROWS - 1 - row, COLUMNS - 1 - column, row, column)[wall]


def relative(cell: Cell, origin: Cell, quarter: int) -> tuple[int, int]:
    """How far a cell is to the right of and ahead of another one, seen in the direction of a quarter (0 is +row)."""
    x, y = cell[0] - origin[0], cell[1] - origin[1]
    return ((x, y), (-y, x), (-x, -y), (y, -x))[quarter]


def _distance(cell: Cell, other: Cell) -> int:
    return abs(cell[0] - other[0]) + abs(cell[1] - other[1])

"""Grading of the assembly room's cells by the relations that an instruction states, for planners and followers.

All relations are seen by an agent on the start tile after the stated turns: "behind" is one cell farther along its
viewing direction, "left of" one cell to its left, and so on, wherever the landmark is. So "turn right and place it left
of the mug" means the cell one row above the mug's. (The release's second turns confirm this where they name the object
placed in the first: after a turn to the right, left is +row in all cases.) The paper calls relations to the agent and
turns egocentric, relations between things allocentric; both use this frame. Each relation grades the cells, nearest
cells highest; the target cell has the best product of grades. The object is placed on the floor unless the text says
that it goes on top of something.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from arramon_client.world import COLUMNS, ROOM_START, ROWS
from arramon_lang.meaning import Assembly, Thing, Where
from arramon_lang.street_words import DEGREES

START = ROOM_START
"""Start tile of the agent, which initially faces +row."""

Cell = tuple[int, int]
"""(column, row)."""

MISMATCH = {"kind": 0.05, "colour": 0.15, "look": 0.3}
"""Factor on the likelihood of a referent for each stated attribute that does not match: people confuse patterns more
often than kinds."""

MIN_GRADE = 0.01
"""Minimum grade of a cell for a relation, above 0 so that a misread relation does not exclude a cell."""

OCCUPIED = 0.05
"""Factor on occupied cells, unless the text says "on top"."""

OUT_OF_VIEW = 0.6
"""Factor on things that the agent does not face after the stated turns."""

DIAGONAL_SIDE = 0.6
"""Grade of a cell ahead and to one side for "to your left" or "to your right"."""

EDGE = 0.7
"""Factor on column 0, where neither the original nor generated episodes place objects."""


@dataclass(frozen=True, slots=True)
class RoomObject:
    """An object in the room; `level` 1 is on the floor."""

    kind: str
    colour: str
    look: str
    column: int
    row: int
    level: int = 1

    @property
    def cell(self) -> Cell:
        """The (column, row) of the object."""
        return self.column, self.row


@dataclass(frozen=True, slots=True)
class Room:
    """Known objects of the room, and positions of its walls.

    Attributes:
        things: all known objects.
        walls: by look of each known wall, its quarter, clockwise from +row: 0 beyond the last row, 1 beyond the last
            column, 2 before row 0, 3 before column 0.
    """

    things: tuple[RoomObject, ...]
    walls: Mapping[str, int]

    def height(self, cell: Cell) -> int:
        """Return the number of objects stacked on a cell."""
        return max((thing.level for thing in self.things if thing.cell == cell), default=0)


Referent = RoomObject | int | None
"""What a landmark's name refers to: an object, the quarter of a wall, or None for the agent."""


def quarter_after(turns: tuple[str, ...]) -> int:
    """Return the agent's viewing direction after the turns, in quarter turns clockwise from +row, rounded."""
    return round(sum(DEGREES[turn] for turn in turns) / 90) % 4


def find_cell(meaning: Assembly, room: Room) -> tuple[Cell, float]:
    """Return the best cell for the object, and its weight divided by the second best's: at least 1, possibly inf.

    Ties go to the cell nearest to the start tile, then to the first in column and row.
    """
    weights = weigh_cells(meaning, room)
    first, second = sorted(weights, key=lambda cell: (-weights[cell], _distance(cell, START), cell))[:2]
    return first, weights[first] / weights[second] if weights[second] else math.inf


def is_all_there(meaning: Assembly, room: Room) -> bool:
    """Return whether every named thing has an object that matches all of its stated attributes."""
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
    """Return the weight of each cell except the start tile, from 0 to 1: how well it fits the whole instruction."""
    quarter = quarter_after(meaning.turns)
    landmarks = [_landmarks(where, room, quarter, is_facing_stated=bool(meaning.turns)) for where in meaning.where]
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


def weigh_things(thing: Thing, room: Room, quarter: int, *, is_facing_stated: bool) -> list[tuple[float, Referent]]:
    """Return the possible referents of a name with their likelihoods, from 0 to 1; empty if none is of its kind.

    Args:
        thing: the name.
        room: all known objects.
        quarter: viewing direction of the agent.
        is_facing_stated: whether the instruction states that direction, so that things in front of the agent are
            likelier.
    """
    if thing.kind == "you":
        return [(1.0, None)]
    if thing.kind == "corner":  # The text does not identify which corner.
        return []
    if thing.kind == "wall":
        weights: list[tuple[float, Referent]] = [
            (_matching(thing, look=look) * (1.0 if thing.look or q == quarter else 0.5), q)
            for look, q in room.walls.items()
        ]
        return _likely(weights)
    graded: list[tuple[float, RoomObject]] = []
    for item in room.things:
        weight = _matching(thing, kind=item.kind, colour=item.colour, look=item.look)
        for where in thing.where:
            others = Room(tuple(other for other in room.things if other != item), room.walls)
            found = _landmarks(where, others, quarter, is_facing_stated=False)
            weight *= max(
                (w * grade_relation(where, item.cell, item.level, marks, quarter) for w, marks in found), default=1.0
            )
        across, ahead = relative(item.cell, START, quarter)
        if is_facing_stated and abs(across) > 2 * ahead:  # more than 63 degrees off the viewing direction
            weight *= OUT_OF_VIEW
        graded.append((weight, item))
    return _likely(_counted(thing.which, graded))


def _matching(thing: Thing, **words: str) -> float:
    """Return the likelihood of a referent with these attributes, by the name alone."""
    weight = 1.0
    for attribute, word in words.items():
        stated = getattr(thing, attribute)
        if stated and stated != word:
            weight *= MISMATCH[attribute]
    return weight


def _counted(which: str, graded: list[tuple[float, RoomObject]]) -> list[tuple[float, Referent]]:
    """Apply an ordinal ("first", "last") to the best matches, ordered by distance from the agent."""
    if not which or not graded:
        return list(graded)
    most = max(weight for weight, _ in graded)
    fitting = sorted((item for weight, item in graded if weight > most / 2), key=lambda i: _distance(i.cell, START))
    place = {"second": 1, "last": -1}.get(which, 0)
    chosen = fitting[place if place < len(fitting) else -1]
    return [(weight if item == chosen else weight * 0.3, item) for weight, item in graded]


def _likely(weights: list[tuple[float, Referent]]) -> list[tuple[float, Referent]]:
    """Drop candidates that are much less likely than the best."""
    most = max((weight for weight, _ in weights), default=0.0)
    return [(weight, landmark) for weight, landmark in weights if weight > 0.3 * most]


def _landmarks(
    where: Where, room: Room, quarter: int, *, is_facing_stated: bool
) -> list[tuple[float, tuple[Referent, ...]]]:
    """Return combinations of referents for a relation's things; empty if one has no referent."""
    each = [weigh_things(thing, room, quarter, is_facing_stated=is_facing_stated) for thing in where.things]
    if len(each) == 1:
        return [(weight, (landmark,)) for weight, landmark in each[0]]
    return [(v * w, (one, other)) for v, one in each[0] for w, other in each[1] if one != other]


def grade_relation(where: Where, cell: Cell, level: int, landmarks: tuple[Referent, ...], quarter: int) -> float:
    """Return how well an object at (cell, level) fits a relation to landmarks, from 0 to 1."""
    if where.relation == "between":
        grade = _grade_between(cell, landmarks)
    elif isinstance(landmarks[0], int):
        grade = {0: 1.0, 1: 0.15}.get(_from_wall(cell, landmarks[0]), 2 * MIN_GRADE)
    elif where.relation == "on_top_of":
        mark = landmarks[0]
        is_above = mark is not None and cell == mark.cell and level > mark.level
        grade = 0.0 if not is_above else 1.0 if mark is not None and level == mark.level + 1 else 0.8
    else:
        mark = landmarks[0]
        across, ahead = relative(cell, START if mark is None else mark.cell, quarter)
        relation = where.relation
        if mark is None and relation in ("in_front_of", "behind"):  # In front of the agent is its far side.
            ahead = -ahead
        grade = _grade_offset(relation, across, ahead)
        if mark is None and relation in ("left_of", "right_of") and ahead > 0 and grade:
            grade = DIAGONAL_SIDE
    return max(grade * grade if where.exactly else grade, MIN_GRADE)


@cache
def _grade_offset(relation: str, across: int, ahead: int) -> float:
    """Return how well a cell fits a relation, given its offset to the right of and ahead of the landmark."""
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


def _grade_between(cell: Cell, landmarks: tuple[Referent, ...]) -> float:
    """Grade "between", highest in the middle of a straight line; a wall counts as the cell in front of it."""
    ends = [START if mark is None else mark.cell for mark in landmarks if not isinstance(mark, int)]
    walls = [mark for mark in landmarks if isinstance(mark, int)]
    if not ends:
        return min({0: 1.0, 1: 0.3}.get(_from_wall(cell, wall), MIN_GRADE) for wall in walls)
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
    """Return the cell outside the room, beyond a wall, in line with a cell."""
    column, row = cell
    return ((column, ROWS), (COLUMNS, row), (column, -1), (-1, row))[wall]


def _from_wall(cell: Cell, wall: int) -> int:
    """Return the number of cells between a cell and a wall."""
    column, row = cell
    return (ROWS - 1 - row, COLUMNS - 1 - column, row, column)[wall]


def relative(cell: Cell, origin: Cell, quarter: int) -> tuple[int, int]:
    """Return the offset of a cell to the right of and ahead of another, facing a quarter (0 is +row)."""
    x, y = cell[0] - origin[0], cell[1] - origin[1]
    return ((x, y), (-y, x), (-x, -y), (y, -x))[quarter]


def _distance(cell: Cell, other: Cell) -> int:
    return abs(cell[0] - other[0]) + abs(cell[1] - other[1])

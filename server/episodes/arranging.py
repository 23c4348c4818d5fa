"""Places the decoys that assembly instructions speak of, so that what these say of the target's cell is true.

What the words mean is `lang.placing`'s to say: the same that a follower goes by.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from random import Random

from lang.meaning import Assembly, Thing, Where
from lang.placing import Landmark, find_cell, grade_relation, quarter_after
from server.episodes.instruct.assembly_sight import standing, whole_room
from server.sim.catalogue import ALL_TYPES, KINDS, ObjectType
from server.sim.room import COLUMNS, ROWS, Placement, Square
from server.sim.rules import PlacedObject

CELLS = tuple(Square(column, row) for row in range(ROWS) for column in range(COLUMNS))

FITTING = 0.5
"""Beside the best place for a decoy, those are tried that are at least so good, as a share of the best."""

STANDS = 0.3
"""What is there already is what an incomplete name means, if it stands at least so well as it is said to."""


def leads_to(meaning: Assembly, room: Sequence[PlacedObject], placement: Placement) -> bool:
    """Whether an instruction, followed in a room, leads to the cell of a placement."""
    return find_cell(meaning, whole_room(tuple(room)))[0] == (placement.column, placement.row)


@dataclass(frozen=True, slots=True)
class Arrangement:
    """Puts on the floor what one instruction after the other speaks of.

    Attributes:
        floor: the decoys that stand there; more are added to it.
        shut: cells where none may stand.
        walked: cells where one stands only if no other place is as good.
        unlike: types that no decoy is to have.
        most: how many decoys there may be.
        is_bold: whether not the best place is taken, but one drawn among those that are good enough.
        random: draws what the instructions leave open.
    """

    floor: dict[Square, ObjectType]
    shut: Collection[Square]
    walked: Collection[Square]
    unlike: Collection[ObjectType]
    most: int
    is_bold: bool
    random: Random

    def add(self, meaning: Assembly, placement: Placement, placed: Sequence[PlacedObject]) -> None:
        """Puts down what an instruction speaks of and is not there yet.

        Args:
            meaning: the instruction's.
            placement: where it is to lead.
            placed: what stands in the room besides decoys: in the second turn the first's object.
        """
        for where in meaning.where:
            self._relate(where, placement, quarter_after(meaning.turns), placed)

    def items(self) -> list[PlacedObject]:
        """The decoys, with their places."""
        return [PlacedObject(type_, Placement(cell.column, 1, cell.row)) for cell, type_ in sorted(self.floor.items())]

    def _relate(self, where: Where, subject: Placement, quarter: int, placed: Sequence[PlacedObject]) -> None:
        """Puts the landmarks of a relation so that it is true of `subject`, and then those that they are named by."""
        known: list[Landmark] = []
        missing: list[Thing] = []
        for thing in where.things:
            if thing.kind == "you":
                known.append(None)
            elif thing.kind == "wall":
                known.append(whole_room(()).walls.get(thing.look, quarter))
            elif (item := self._find(thing, where, subject, quarter, placed)) is not None:
                known.append(standing(item))
                self._relate_all(thing, item, quarter, placed)
            elif thing.kind in KINDS or (not thing.kind and (thing.colour or thing.look)):
                missing.append(thing)
        for thing in missing:
            new = self._put(thing, where, subject, known, quarter)
            if new is not None:
                known.append(standing(new))
                self._relate_all(thing, new, quarter, placed)

    def _relate_all(self, thing: Thing, item: PlacedObject, quarter: int, placed: Sequence[PlacedObject]) -> None:
        for where in thing.where:
            self._relate(where, item.placement, quarter, placed)

    def _find(
        self, thing: Thing, where: Where, subject: Placement, quarter: int, placed: Sequence[PlacedObject]
    ) -> PlacedObject | None:
        """What is there already that the name means: by a complete name, or else by where it stands."""
        fitting = [item for item in (*self.items(), *placed) if fits(thing, item.type)]
        if fitting and thing.kind and thing.colour and thing.look:
            return fitting[0]
        graded = [(grade_alone(where, subject, standing(item), quarter), item) for item in fitting]
        good = [(grade, item.placement, item) for grade, item in graded if grade >= STANDS]
        return max(good)[2] if good else None

    def _put(
        self, thing: Thing, where: Where, subject: Placement, known: Sequence[Landmark], quarter: int
    ) -> PlacedObject | None:
        """Another decoy of that name, where the relation is true; None where there is no such place or type."""
        used = {*self.unlike, *self.floor.values()}
        types = [type_ for type_ in ALL_TYPES if fits(thing, type_) and type_ not in used]
        cells = [cell for cell in CELLS if cell not in self.floor and cell not in self.shut]
        if not types or not cells or len(self.floor) >= self.most:
            return None
        type_ = self.random.choice(types)
        graded = {}
        for cell in self.random.sample(cells, len(cells)):
            mark = standing(PlacedObject(type_, Placement(cell.column, 1, cell.row)))
            if where.relation == "between" and known:
                at = subject.column, subject.row
                graded[cell] = grade_relation(where, at, subject.level, (known[0], mark), quarter)
            else:
                graded[cell] = grade_alone(where, subject, mark, quarter)
        best = max(graded.values())
        good = [cell for cell in graded if graded[cell] >= (FITTING if self.is_bold else 1.0) * best]
        cell = good[0] if self.is_bold else min(good, key=lambda cell: cell in self.walked)
        self.floor[cell] = type_
        return PlacedObject(type_, Placement(cell.column, 1, cell.row))


def grade_alone(where: Where, subject: Placement, landmark: Landmark, quarter: int) -> float:
    """How well `subject` stands so to one landmark; to one of two it should at least be near."""
    if where.relation == "between":
        where = Where("near", where.things[:1])
    return grade_relation(where, (subject.column, subject.row), subject.level, (landmark,), quarter)


def fits(thing: Thing, type_: ObjectType) -> bool:
    """Whether every word of a name is true of a type."""
    return thing.kind in ("", type_.kind) and thing.colour in ("", type_.colour) and thing.look in ("", type_.pattern)

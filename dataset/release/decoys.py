"""Placement of the decoys that assembly instructions mention, so that the instructions identify the target's cell.

The semantics of relations is that of `arramon_lang.cell_grading`, shared with followers.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from random import Random

from arramon_client.world import COLLECTIBLES, COLUMNS, ROWS
from arramon_dataset.instructions.assembly.visible_objects import to_room_object, whole_room
from arramon_lang.cell_grading import Referent, find_cell, grade_relation, quarter_after
from arramon_lang.meaning import Assembly, Thing, Where
from arramon_server.sim.catalogue import ALL_TYPES, ObjectType
from arramon_server.sim.room import RoomCell, RoomPosition
from arramon_server.sim.rules import PlacedObject

CELLS = tuple(RoomCell(column, row) for row in range(ROWS) for column in range(COLUMNS))

MIN_FIT = 0.5
"""Minimum fit of a random placement of a decoy, relative to the best placement."""

MIN_GRADE = 0.3
"""Minimum grade of a relation at which an incomplete name may refer to an existing object."""


def identifies_cell(meaning: Assembly, room: Sequence[PlacedObject], placement: RoomPosition) -> bool:
    """Return whether an instruction identifies the cell of a placement in a room."""
    return find_cell(meaning, whole_room(tuple(room)))[0] == (placement.column, placement.row)


@dataclass(frozen=True, slots=True)
class DecoyPlacer:
    """Places the decoys of one instruction after another.

    Attributes:
        floor: decoys by cell; `add` extends it.
        blocked: cells that must stay free of decoys.
        walked: cells of the ground truth, which get a decoy only if no other cell is as good.
        excluded: types that no decoy may have.
        max_decoys: maximum number of decoys.
        is_random: whether to draw among all sufficiently good cells instead of taking the best.
        random: draws types and cells that the instructions leave open.
    """

    floor: dict[RoomCell, ObjectType]
    blocked: Collection[RoomCell]
    walked: Collection[RoomCell]
    excluded: Collection[ObjectType]
    max_decoys: int
    is_random: bool
    random: Random

    def add(self, meaning: Assembly, placement: RoomPosition, placed: Sequence[PlacedObject]) -> None:
        """Add a decoy for each object that an instruction mentions and that does not exist yet.

        Args:
            meaning: of the instruction.
            placement: the target's, which the instruction should identify.
            placed: objects in the room besides decoys: in turn 2, the object placed in turn 1.
        """
        for where in meaning.where:
            self._relate(where, placement, quarter_after(meaning.turns), placed)

    def items(self) -> list[PlacedObject]:
        """Return the decoys with their placements."""
        return [
            PlacedObject(type_, RoomPosition(cell.column, 1, cell.row)) for cell, type_ in sorted(self.floor.items())
        ]

    def _relate(self, where: Where, subject: RoomPosition, quarter: int, placed: Sequence[PlacedObject]) -> None:
        """Place the landmarks of a relation so that it holds for `subject`, then those in their own relations."""
        known: list[Referent] = []
        missing: list[Thing] = []
        for thing in where.things:
            if thing.kind == "you":
                known.append(None)
            elif thing.kind == "wall":
                known.append(whole_room(()).walls.get(thing.look, quarter))
            elif (item := self._find(thing, where, subject, quarter, placed)) is not None:
                known.append(to_room_object(item))
                self._relate_all(thing, item, quarter, placed)
            elif thing.kind in COLLECTIBLES or (not thing.kind and (thing.colour or thing.look)):
                missing.append(thing)
        for thing in missing:
            new = self._add_decoy(thing, where, subject, known, quarter)
            if new is not None:
                known.append(to_room_object(new))
                self._relate_all(thing, new, quarter, placed)

    def _relate_all(self, thing: Thing, item: PlacedObject, quarter: int, placed: Sequence[PlacedObject]) -> None:
        for where in thing.where:
            self._relate(where, item.placement, quarter, placed)

    def _find(
        self, thing: Thing, where: Where, subject: RoomPosition, quarter: int, placed: Sequence[PlacedObject]
    ) -> PlacedObject | None:
        """Return the existing object that a name refers to, by its complete name or by the relation, or None."""
        fitting = [item for item in (*self.items(), *placed) if name_matches_type(thing, item.type)]
        if fitting and thing.kind and thing.colour and thing.look:
            return fitting[0]
        graded = [(relation_score(where, subject, to_room_object(item), quarter), item) for item in fitting]
        good = [(grade, item.placement, item) for grade, item in graded if grade >= MIN_GRADE]
        return max(good)[2] if good else None

    def _add_decoy(
        self, thing: Thing, where: Where, subject: RoomPosition, known: Sequence[Referent], quarter: int
    ) -> PlacedObject | None:
        """Add and return a decoy with that name for which the relation holds, or None if no cell or type is left."""
        used = {*self.excluded, *self.floor.values()}
        types = [type_ for type_ in ALL_TYPES if name_matches_type(thing, type_) and type_ not in used]
        cells = [cell for cell in CELLS if cell not in self.floor and cell not in self.blocked]
        if not types or not cells or len(self.floor) >= self.max_decoys:
            return None
        type_ = self.random.choice(types)
        graded = {}
        for cell in self.random.sample(cells, len(cells)):
            mark = to_room_object(PlacedObject(type_, RoomPosition(cell.column, 1, cell.row)))
            if where.relation == "between" and known:
                at = subject.column, subject.row
                graded[cell] = grade_relation(where, at, subject.level, (known[0], mark), quarter)
            else:
                graded[cell] = relation_score(where, subject, mark, quarter)
        best = max(graded.values())
        good = [cell for cell in graded if graded[cell] >= (MIN_FIT if self.is_random else 1.0) * best]
        cell = good[0] if self.is_random else min(good, key=lambda cell: cell in self.walked)
        self.floor[cell] = type_
        return PlacedObject(type_, RoomPosition(cell.column, 1, cell.row))


def relation_score(where: Where, subject: RoomPosition, landmark: Referent, quarter: int) -> float:
    """Return how well a relation to one landmark holds for `subject`; for "between", how near they are."""
    if where.relation == "between":
        where = Where("near", where.things[:1])
    return grade_relation(where, (subject.column, subject.row), subject.level, (landmark,), quarter)


def name_matches_type(thing: Thing, type_: ObjectType) -> bool:
    """Return whether every word of a name matches a type."""
    return thing.kind in ("", type_.kind) and thing.colour in ("", type_.colour) and thing.look in ("", type_.pattern)

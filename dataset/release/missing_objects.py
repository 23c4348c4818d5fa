"""Objects that the release lacks, drawn by an episode's id: distracters in its streets, decoys in its room."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from random import Random

import numpy as np
import numpy.typing as npt

from arramon_client.world import COLUMNS, REACH_AHEAD, REACH_SIDE, ROWS
from arramon_dataset.randomness import seeded
from arramon_dataset.release.decoys import DecoyPlacer, identifies_cell
from arramon_lang import Language, Mention
from arramon_lang.meaning import Assembly
from arramon_server.sim.catalogue import ALL_TYPES, EXTENT, ObjectType
from arramon_server.sim.geometry import Point, Pose
from arramon_server.sim.room import START, RoomCell, RoomPosition
from arramon_server.sim.rules import PlacedObject

Points = npt.NDArray[np.float64]

FROM_PATH, FROM_TARGET, FROM_EACH_OTHER = 1.2, 2.0, 1.0
"""Minimum distances of distracters from the ground-truth path, the target and each other, in units."""

NEARBY = (3.0, 12.0)
"""Range of distances from the path, in units, for two thirds of the distracters."""

TRIED = 400
"""Maximum number of places tried for the distracters of one turn."""

DECOYS = 8
"""Number of objects in the room when the first assembly phase begins (paper, section 3.1)."""

ATTRIBUTES = ("pattern", "colour", "kind")

ATTEMPTS = 12
"""Maximum number of rooms drawn until the instructions identify the targets' cells."""

SHARED_COMBINATIONS = tuple(words for size in (1, 2) for words in combinations(ATTRIBUTES, size))
"""Combinations of attributes that a distracter may share with the target: at least one, but not all."""

OFFSETS = {"on_top_of": (0, 0), "left_of": (1, 0), "right_of": (-1, 0), "behind": (0, -1), "in_front_of": (0, 1)}
"""By the target's relation to an object: offset of the object from the target's cell, in (columns, rows)."""


@dataclass(frozen=True, slots=True)
class ObjectReference:
    """An object that an assembly instruction mentions, and the target's relation to it.

    Attributes:
        mention: its name, possibly incomplete.
        relation: one of `lang`'s, such as "on_top_of" or "left_of"; None if none is stated.
    """

    mention: Mention
    relation: str | None

    def complete_type(self) -> ObjectType | None:
        """Return the type if the name is complete, else None."""
        pattern, colour, kind = self.mention.pattern, self.mention.colour, self.mention.kind
        return ObjectType(pattern, colour, kind) if pattern and colour and kind else None

    def fits(self, candidate: ObjectType) -> bool:
        """Return whether the name matches a type; attributes that it leaves out match anything."""
        return all(getattr(self.mention, word) in (None, getattr(candidate, word)) for word in ATTRIBUTES)


def read_references(instruction: str, language: Language) -> tuple[ObjectReference, ...]:
    """Return the objects that an assembly instruction mentions, in order."""
    mentions = language.find_objects(instruction)
    return tuple(ObjectReference(mention, language.relation_of(instruction, mention)) for mention in mentions)


def draw_distracters(
    episode_id: str,
    turn: int,
    target: ObjectType,
    target_position: Point,
    path: Points,
    final_pose: Pose,
    ground: Points,
) -> tuple[tuple[ObjectType, Point], ...]:
    """Return five to seven objects on free ground that share attributes with the target; fewer if they do not fit.

    None is near the ground truth's path, or in the pick-up box at its end.

    Args:
        episode_id: seeds the result together with the turn.
        turn: 1 or 2.
        target: type of the object to pick up.
        target_position: position of that object.
        path: (n, 2) of (x, z), the turn's ground truth, n at least 1.
        final_pose: pose at the end of the ground truth.
        ground: (m, 2) of (x, z): walkable places, such as all points of the section's paths.
    """
    random = seeded(episode_id, turn, "distracters")
    wanted = random.randint(5, 7)
    places = ground[random.sample(range(len(ground)), min(TRIED, len(ground)))]
    distance = distance_to_path(places, path)
    clear = (distance >= FROM_PATH) & (
        np.hypot(places[:, 0] - target_position.x, places[:, 1] - target_position.z) >= FROM_TARGET
    )
    places, distance = places[clear], distance[clear]
    is_nearby = (distance >= NEARBY[0]) & (distance <= NEARBY[1])
    # The random order within each group is kept.
    nearby, elsewhere = np.flatnonzero(is_nearby), np.flatnonzero(~is_nearby)
    chosen: list[Points] = []
    for order, enough in ((nearby, (2 * wanted + 2) // 3), (elsewhere, wanted), (nearby, wanted)):
        for index in order:
            if len(chosen) >= enough:
                break
            place = places[index]
            if not in_pick_up_box(final_pose, place) and is_apart(place, chosen):
                chosen.append(place)
    kinds = similar_types(target, len(chosen), random)
    return tuple((kind, Point(float(x), 0.0, float(z))) for kind, (x, z) in zip(kinds, chosen, strict=True))


def distance_to_path(places: Points, path: Points) -> Points:
    """Return the distance of each of `places` (m, 2) from the polyline `path` (n, 2), in units, (m,)."""
    starts, ends = (path[:-1], path[1:]) if len(path) > 1 else (path, path)
    along = ends - starts
    squared = np.maximum((along**2).sum(axis=1), 1e-12)
    fraction = np.clip(((places[:, None] - starts) * along).sum(axis=2) / squared, 0.0, 1.0)
    nearest = starts + fraction[:, :, None] * along
    distance: Points = np.linalg.norm(places[:, None] - nearest, axis=2).min(axis=1)
    return distance


def in_pick_up_box(pose: Pose, place: Points) -> bool:
    """Return whether an object at `place` overlaps the box from which an agent at `pose` picks up."""
    right, ahead = pose.local(float(place[0]), float(place[1]))
    return abs(right) <= REACH_SIDE + EXTENT and -EXTENT <= ahead <= REACH_AHEAD + EXTENT


def is_apart(place: Points, others: Sequence[Points]) -> bool:
    """Return whether `place` is far enough from the other distracters."""
    return all(np.hypot(*(place - other)) >= FROM_EACH_OTHER for other in others)


def similar_types(target: ObjectType, count: int, random: Random) -> list[ObjectType]:
    """Return `count` distinct types that share attributes with the target, cycling through the combinations."""
    alike: dict[tuple[str, ...], list[ObjectType]] = {}
    for other in ALL_TYPES:
        alike.setdefault(shared_attributes(target, other), []).append(other)
    types: list[ObjectType] = []
    combinations_left: list[tuple[str, ...]] = []
    while len(types) < count:
        combinations_left = combinations_left or random.sample(SHARED_COMBINATIONS, len(SHARED_COMBINATIONS))
        shared = combinations_left.pop()
        fitting = [other for other in alike[shared] if other not in types]
        if fitting:
            types.append(random.choice(fitting))
    return types


def shared_attributes(one: ObjectType, other: ObjectType) -> tuple[str, ...]:
    """Return the attributes in which two types agree."""
    return tuple(word for word in ATTRIBUTES if getattr(one, word) == getattr(other, word))


def arrange_decoys(
    episode_id: str,
    targets: tuple[ObjectType, ObjectType],
    placements: tuple[RoomPosition, RoomPosition],
    walks: tuple[Sequence[RoomCell], Sequence[RoomCell]],
    references: tuple[Sequence[ObjectReference], Sequence[ObjectReference]],
    meanings: tuple[Assembly | None, Assembly | None] = (None, None),
) -> tuple[tuple[ObjectType, RoomCell], ...]:
    """Return eight objects on the room's floor for the first assembly phase; fewer if they do not fit.

    If a target goes on top of an object other than the first turn's target, a decoy is placed there: the one that the
    instruction names. Other objects that the instructions mention are placed where their meanings hold, even on cells
    that the ground truth crosses (objects do not block agents; the official release's ground truth crosses some).
    Several such rooms are drawn: the result is the first in which both instructions identify the targets' cells, or
    else one in which the most do. Objects mentioned in an instruction without a known meaning are placed in the stated
    relation or near it. No other decoy is on the ground truth's cells or target cells.

    Args:
        episode_id: seeds all choices that the instructions leave open.
        targets: of both turns.
        placements: target cells of both turns.
        walks: cells of both turns' ground truth.
        references: objects that each turn's assembly instruction mentions.
        meanings: of these instructions; None for one that could not be read.
    """
    random = seeded(episode_id, "decoys")
    readable = [(turn, meaning) for turn, meaning in enumerate(meanings) if meaning is not None and meaning.where]
    first = PlacedObject(targets[0], placements[0])
    best: tuple[tuple[ObjectType, RoomCell], ...] = ()
    most = -1
    for attempt in range(ATTEMPTS if readable else 1):
        room = _arrange(attempt, targets, placements, walks, references, meanings, random)
        items = [PlacedObject(kind, RoomPosition(cell.column, 1, cell.row)) for cell, kind in room.items()]
        true = sum(identifies_cell(meaning, items + [first] * turn, placements[turn]) for turn, meaning in readable)
        if true > most:
            best, most = tuple((kind, cell) for cell, kind in sorted(room.items())), true
        if most == len(readable):
            break
    return best


def _arrange(
    attempt: int,
    targets: tuple[ObjectType, ObjectType],
    placements: tuple[RoomPosition, RoomPosition],
    walks: tuple[Sequence[RoomCell], Sequence[RoomCell]],
    references: tuple[Sequence[ObjectReference], Sequence[ObjectReference]],
    meanings: tuple[Assembly | None, Assembly | None],
    random: Random,
) -> dict[RoomCell, ObjectType]:
    """Return one room for `arrange_decoys`; attempt 0 puts everything in its best place."""
    cells = [RoomCell(place.column, place.row) for place in placements]
    stands = [turn for turn in (0, 1) if placements[turn].level == 2 and not (turn == 1 and rests_on_first(placements))]
    walked = {*walks[0], *walks[1]}
    room: dict[RoomCell, ObjectType] = {}
    for turn in stands:
        if cells[turn] not in room:
            room[cells[turn]] = supporting_type(targets, turn, references[turn], room, random)
    placer = DecoyPlacer(room, {START, *cells}, walked, targets, DECOYS, attempt > 0, random)
    for turn in (0, 1) if attempt % 2 == 0 else (1, 0):
        meaning = meanings[turn]
        if meaning is not None:
            placer.add(meaning, placements[turn], [PlacedObject(targets[0], placements[0])] * turn)
    shut = {START, *walked, *cells, *room}
    free = [RoomCell(column, row) for row in range(ROWS) for column in range(COLUMNS)]
    free = [cell for cell in free if cell not in shut]
    for turn in (0, 1):
        for reference in references[turn]:
            name = reference.complete_type()
            if name is None or name in targets or name in room.values() or not free or len(room) >= DECOYS:
                continue
            cell = related_cell(cells[turn], reference.relation, free)
            free.remove(cell)
            room[cell] = name
    others = [other for other in ALL_TYPES if other not in targets and other not in room.values()]
    count = min(DECOYS - len(room), len(free))
    return room | dict(zip(random.sample(free, count), random.sample(others, count), strict=True))


def rests_on_first(placements: tuple[RoomPosition, RoomPosition]) -> bool:
    """Return whether the second turn's target goes on top of the first's, which is on the floor."""
    first, second = placements
    return first.level == 1 and (first.column, first.row) == (second.column, second.row)


def supporting_type(
    targets: tuple[ObjectType, ObjectType],
    turn: int,
    references: Sequence[ObjectReference],
    room: dict[RoomCell, ObjectType],
    random: Random,
) -> ObjectType:
    """Return the type of the object below the target: as the instruction names it, or any that matches its words.

    It may equal the target's own type ("on top of the other striped yellow ball") if no other is named.
    """
    on_top = [reference for reference in references if reference.relation == "on_top_of"]
    names = [name for name in (reference.complete_type() for reference in on_top) if name is not None]
    if names:
        return min(names, key=lambda name: name == targets[turn])
    unlike = [other for other in ALL_TYPES if other not in targets and other not in room.values()]
    fitting = [other for other in unlike if any(reference.fits(other) for reference in on_top)]
    return random.choice(fitting or unlike)


def related_cell(target: RoomCell, relation: str | None, free: Sequence[RoomCell]) -> RoomCell:
    """Return the free cell of an object to which the target has that relation; if taken, the nearest free cell."""
    columns, rows = OFFSETS.get(relation or "", (0, 0))
    wanted = RoomCell(target.column + columns, target.row + rows)
    if wanted in free:
        return wanted
    return min(free, key=lambda cell: (abs(cell.column - target.column) + abs(cell.row - target.row), cell))

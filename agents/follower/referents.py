"""Reference resolution: the landmarks to which the mentions of an instruction refer, consistently over mentions."""

import math
from collections.abc import Sequence

from arramon_agents.mapping.landmark_memory import LandmarkMemory, MappedLandmark, landmarks_ahead
from arramon_lang.meaning import Thing
from arramon_lang.street_words import COUNTED_WITHIN, GROUP_RADIUS

ORDINALS = {"first": 0, "second": 1, "third": 2, "last": -1}

Marks = tuple[MappedLandmark, ...]


class Referents:
    """Resolves the things of one instruction to landmarks, and remembers those already resolved.

    Args:
        landmarks: all landmarks seen.
    """

    def __init__(self, landmarks: LandmarkMemory) -> None:
        self._landmarks = landmarks
        self._known: dict[str, Marks] = {}

    def store(self, thing: Thing, marks: Marks) -> None:
        """Store the referent of a thing."""
        if thing.identity and marks:
            self._known[thing.identity] = marks

    def find(self, thing: Thing, x: float, z: float, angle: float) -> Marks | None:
        """Return the referent of a thing for a walk from (x, z) in direction `angle`; None if it has not been seen.

        Groups and buildings (which are seen in pieces) are several landmarks.
        """
        if thing.identity in self._known:
            return self._known[thing.identity]
        marks = landmarks_ahead(self._landmarks.matching(thing), x, z, angle)
        if thing.which in ("next", "another"):
            others = [mark for known in self._known.values() for mark in known]
            marks = [mark for mark in marks if mark not in others]
        if thing.where and marks:
            marks.sort(key=lambda mark: (self._distance_to_landmarks(thing, mark), mark.x))
        if thing.which in ORDINALS:
            marks = _counted(marks, thing.which, x, z, angle)
        if not marks:
            return None
        first = marks[0]
        if thing.number or thing.kind == "building":
            group = [mark for mark in marks if math.hypot(mark.x - first.x, mark.z - first.z) <= GROUP_RADIUS]
            return None if thing.number and len(group) < 2 else tuple(group[:2] if thing.number == "two" else group)
        return (first,)

    def _distance_to_landmarks(self, thing: Thing, mark: MappedLandmark) -> float:
        """Return the distance of a landmark from the reference objects of a thing, in units."""
        total = 0.0
        for where in thing.where:
            for other in where.things:
                near = self._landmarks.matching(other)
                total += min((math.hypot(o.x - mark.x, o.z - mark.z) for o in near), default=0.0)
        return total


def _counted(marks: Sequence[MappedLandmark], which: str, x: float, z: float, angle: float) -> list[MappedLandmark]:
    """Return the landmark with an ordinal along the walk; empty if there are fewer."""
    sin, cos = math.sin(angle), math.cos(angle)
    ahead = []
    for mark in marks:
        dx, dz = mark.x - x, mark.z - z
        if abs(dx * cos - dz * sin) <= COUNTED_WITHIN:
            ahead.append((dx * sin + dz * cos, mark.x, mark))
    ahead.sort(key=lambda each: each[:2])
    place = ORDINALS[which]
    return [ahead[place][2]] if -len(ahead) <= place < len(ahead) else []

"""Memory of the landmarks seen in the segmentation, without duplicates."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from arramon_agents.perception.scan import Sighting
from arramon_client.agent import Label
from arramon_client.world import COLLECTIBLES
from arramon_lang.meaning import Thing
from arramon_lang.street_words import OFF_AXIS_WEIGHT, is_of_colour

if TYPE_CHECKING:
    from arramon_agents.perception.eyes.detected_things import DetectedThing  # It needs PyTorch.

SAME_LANDMARK_DISTANCE, SAME_LARGE_LANDMARK_DISTANCE = 1.2, 3.0
"""Distance below which two sightings with one label are the same landmark, in units: small things, and LARGE ones."""

LARGE = ("building", "car", "zebra_crossing", "awning")

MIN_SAMPLES, MIN_SAMPLES_OF_COLLECTIBLE = 6, 2
"""Minimum number of samples of a sighting: of a landmark, and of a collectible."""

MIN_AHEAD = -1.0
"""Distance behind the agent, in units, beyond which a landmark is ignored."""

MAX_OFF_COURSE, ALWAYS_NEAR = math.radians(65.0), 3.0
"""Angle off the course in radians beyond which a landmark is ignored, unless it is nearer than ALWAYS_NEAR units."""


@dataclass(slots=True)
class MappedLandmark:
    """A landmark at a place in the agent's own frame; `nearest` is the smallest distance of a sighting, in units."""

    label: Label
    x: float
    z: float
    nearest: float


class LandmarkMemory:
    """Landmarks seen so far, by their label in the segmentation.

    Args:
        labels: labels of the segmentation, by index.

    Attributes:
        used_labels: indices of the labels whose sightings are added; None for all.
    """

    used_labels: frozenset[int] | None = None

    def __init__(self, labels: Sequence[Label]) -> None:
        self._labels = labels
        self._by_label: dict[int, list[MappedLandmark]] = {}

    def add(self, sightings: Iterable[Sighting]) -> None:
        """Add a frame's sightings."""
        for seen in sightings:
            label = self._labels[seen.label]
            if seen.pixels < (MIN_SAMPLES_OF_COLLECTIBLE if label.kind in COLLECTIBLES else MIN_SAMPLES):
                continue
            known = self._by_label.setdefault(seen.label, [])
            apart = SAME_LARGE_LANDMARK_DISTANCE if label.kind in LARGE else SAME_LANDMARK_DISTANCE
            for landmark in known:
                if abs(landmark.x - seen.x) < apart and abs(landmark.z - seen.z) < apart:
                    if seen.distance < 0.8 * landmark.nearest:
                        landmark.x, landmark.z, landmark.nearest = seen.x, seen.z, seen.distance
                    break
            else:
                known.append(MappedLandmark(label, seen.x, seen.z, seen.distance))

    def add_things(self, things: Iterable["DetectedThing"], pose: tuple[float, float, float]) -> None:
        """Ignore the detected things of a frame: landmarks come from the segmentation only."""

    def matching(self, thing: Thing) -> list[MappedLandmark]:
        """Return the landmarks that match the given attributes of a thing."""
        return [
            landmark
            for number, known in self._by_label.items()
            if matches_label(thing, self._labels[number])
            for landmark in known
        ]

    def labelled(self) -> list[MappedLandmark]:
        """Return the landmarks that come from the segmentation."""
        return [landmark for known in self._by_label.values() for landmark in known]

    def forget(self) -> None:
        """Remove all landmarks."""
        self._by_label.clear()

    def forget_collectibles(self) -> None:
        """Remove all collectibles, which differ between turns."""
        for number in [number for number in self._by_label if self._labels[number].kind in COLLECTIBLES]:
            del self._by_label[number]


def matches_label(thing: Thing, label: Label) -> bool:
    """Return whether a segmentation label matches the given attributes of a thing."""
    if thing.kind:
        if thing.kind != label.kind:
            return False
    elif label.kind not in COLLECTIBLES:
        return False
    return thing.look in ("", label.look) and is_of_colour(thing.colour, label.kind, label.colour)


def landmarks_ahead(landmarks: Iterable[MappedLandmark], x: float, z: float, angle: float) -> list[MappedLandmark]:
    """Return the landmarks ahead of (x, z) in the direction `angle` (radians), the most likely referent first."""
    sin, cos = math.sin(angle), math.cos(angle)
    scored = []
    for landmark in landmarks:
        dx, dz = landmark.x - x, landmark.z - z
        if dx * sin + dz * cos < MIN_AHEAD:
            continue
        off, distance = math.atan2(dx * cos - dz * sin, dx * sin + dz * cos), math.hypot(dx, dz)
        if abs(off) < MAX_OFF_COURSE or distance < ALWAYS_NEAR:
            scored.append((distance * (1.0 + OFF_AXIS_WEIGHT * off * off), landmark.x, landmark))
    return [landmark for _, _, landmark in sorted(scored, key=lambda item: item[:2])]

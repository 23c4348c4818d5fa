"""The landmarks that the agent has seen: each label at each place once."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from agents.follower.perceive import COLLECTIBLES, Sighting
from arramon_client.agent import Label
from lang.going import OFF_AXIS
from lang.meaning import Thing

APART, BUILDINGS_APART = 1.2, 3.0
"""Sightings of one label nearer than this to each other, in units, are one thing."""

FEWEST, FEWEST_OF_COLLECTIBLE = 6, 2
"""Samples that make a sighting: of what one steers by, and of what one looks for."""

BEHIND = -1.0
"""A thing farther behind than this, in units, is not what is meant next."""

ASIDE, BESIDE = math.radians(65.0), 3.0
"""Nor is one farther off the course than this, unless it is so near, in units."""


@dataclass(slots=True)
class Landmark:
    """A thing at a place in the agent's own frame; `nearest` is the distance from which it was seen best."""

    label: Label
    x: float
    z: float
    nearest: float


class Landmarks:
    """All that was seen.

    Args:
        labels: what the numbers of a segmentation mean.
    """

    def __init__(self, labels: Sequence[Label]) -> None:
        self._labels = labels
        self._by_label: dict[int, list[Landmark]] = {}

    def add(self, sightings: Iterable[Sighting]) -> None:
        """Enters what a frame shows."""
        for seen in sightings:
            label = self._labels[seen.label]
            if seen.pixels < (FEWEST_OF_COLLECTIBLE if label.kind in COLLECTIBLES else FEWEST):
                continue
            known = self._by_label.setdefault(seen.label, [])
            apart = BUILDINGS_APART if label.kind == "building" else APART
            for landmark in known:
                if abs(landmark.x - seen.x) < apart and abs(landmark.z - seen.z) < apart:
                    if seen.distance < 0.8 * landmark.nearest:
                        landmark.x, landmark.z, landmark.nearest = seen.x, seen.z, seen.distance
                    break
            else:
                known.append(Landmark(label, seen.x, seen.z, seen.distance))

    def fitting(self, thing: Thing) -> list[Landmark]:
        """Those that a thing's name fits, as far as it goes."""
        return [
            landmark
            for number, known in self._by_label.items()
            if fits(thing, self._labels[number])
            for landmark in known
        ]

    def forget(self) -> None:
        """All of them."""
        self._by_label.clear()


def fits(thing: Thing, label: Label) -> bool:
    """Whether a label is one that the thing's name allows."""
    if thing.kind:
        if thing.kind != label.kind:
            return False
    elif label.kind not in COLLECTIBLES:
        return False
    return thing.colour in ("", label.colour) and thing.look in ("", label.look)


def along_way(landmarks: Iterable[Landmark], x: float, z: float, angle: float) -> list[Landmark]:
    """Those ahead of (x, z) on a walk in the direction `angle` (radians), the likeliest to be meant first."""
    sin, cos = math.sin(angle), math.cos(angle)
    scored = []
    for landmark in landmarks:
        dx, dz = landmark.x - x, landmark.z - z
        if dx * sin + dz * cos < BEHIND:
            continue
        off, distance = math.atan2(dx * cos - dz * sin, dx * sin + dz * cos), math.hypot(dx, dz)
        if abs(off) < ASIDE or distance < BESIDE:
            scored.append((distance * (1.0 + OFF_AXIS * off * off), landmark.x, landmark))
    return [landmark for _, _, landmark in sorted(scored, key=lambda item: item[:2])]

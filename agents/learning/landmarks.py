"""Memory of the things seen, by place: what each may be, summed over all views of it."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from agents.follower.map_landmarks import Landmark, Landmarks, fits
from agents.follower.perceive import Sighting
from agents.learning.eyes.names import NamedThing
from agents.learning.eyes.vocabulary import COLLECTIBLES, COLOURS, KINDS, LOOKS, SURFACES
from agents.learning.sight import label_of
from arramon_client.agent import Label
from lang.meaning import Thing

APART, LARGE_APART = 0.75, 2.0
"""Distances in units below which two views are of one thing: of small things, and of LARGE ones."""

LARGE = ("car", "kiosk", "awning", "dumpster", "tree", "shop_sign")

SURE = 0.02
"""Added to each chance before its logarithm is summed: no single view rules anything out."""

FULL, MOST = 150.0, 4.0
"""Pixels of a view that counts once, and how often a view counts at most."""

_NAMED = np.array([kind not in SURFACES for kind in KINDS])


class _Place:
    """A thing at a place, with the sums of logarithms of what it may be.

    Attributes:
        mark: the thing by its most likely names; always the same object.
    """

    def __init__(self, x: float, z: float) -> None:
        self.mark = Landmark(Label(""), x, z, math.inf)
        self._sums = [np.zeros(len(names)) for names in (KINDS, COLOURS, LOOKS)]

    def add(self, named: NamedThing, x: float, z: float, distance: float) -> None:
        """Add a view of the thing."""
        weight = min(MOST, float(named.thing.mask.sum()) / FULL)  # Larger views count for more.
        for total, chances in zip(self._sums, (named.kinds, named.colours, named.looks), strict=True):
            total += weight * np.log(chances.astype(np.float64) + SURE)
        self.mark.label = label_of(*self._sums)
        if distance < 0.9 * self.mark.nearest:
            self.mark.x, self.mark.z, self.mark.nearest = x, z, distance


class SeenLandmarks(Landmarks):
    """All landmarks seen so far: things by place, and buildings and crossings as labels of pixels.

    Args:
        labels: meaning of the label images' values, by index.
    """

    def __init__(self, labels: Sequence[Label]) -> None:
        super().__init__(labels)
        self._flat = {number for number, label in enumerate(labels) if label.kind in ("building", "zebra_crossing")}
        self._places: list[_Place] = []

    def add(self, sightings: Iterable[Sighting]) -> None:
        """Add a frame's buildings and crossings."""
        super().add(sighting for sighting in sightings if sighting.label in self._flat)

    def add_things(self, things: Iterable[NamedThing], pose: tuple[float, float, float]) -> None:
        """Add a frame's things.

        Args:
            things: as named.
            pose: (x, z, radians clockwise) of the camera in the agent's own frame.
        """
        x, z, heading = pose
        sin, cos = math.sin(heading), math.cos(heading)
        for named in things:
            if not _NAMED[int(named.kinds.argmax())]:
                continue
            right, ahead = named.thing.right, named.thing.ahead
            self._add(named, x + right * cos + ahead * sin, z - right * sin + ahead * cos, math.hypot(right, ahead))

    def fitting(self, thing: Thing) -> list[Landmark]:
        """Return the landmarks whose most likely names match a thing's attributes, as far as they are given."""
        return super().fitting(thing) + [place.mark for place in self._places if fits(thing, place.mark.label)]

    def forget(self) -> None:
        """Remove all landmarks."""
        super().forget()
        self._places.clear()

    def _add(self, named: NamedThing, x: float, z: float, distance: float) -> None:
        kind = KINDS[int(named.kinds.argmax())]
        for place in self._places:
            mark = place.mark
            apart = LARGE_APART if kind in LARGE and mark.label.kind == kind else APART
            is_like = (kind in COLLECTIBLES) == (mark.label.kind in COLLECTIBLES)
            if is_like and math.hypot(mark.x - x, mark.z - z) < apart:
                place.add(named, x, z, distance)
                return
        place = _Place(x, z)
        place.add(named, x, z, distance)
        self._places.append(place)

"""Memory of landmarks with probabilities of kind, colour and look, combined over all views of a landmark."""

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.landmark_memory import LandmarkMemory, MappedLandmark, matches_label
from arramon_agents.perception.eyes.detected_things import DetectedThing
from arramon_agents.perception.eyes.predicted_segmentation import label_of
from arramon_agents.perception.eyes.vocabulary import COLOURS, KINDS, LOOKS, NONE, SURFACES, codes_of, look_slices
from arramon_agents.perception.scan import Sighting
from arramon_client.agent import Label
from arramon_client.world import COLLECTIBLES
from arramon_lang.meaning import Thing

SAME_DISTANCE, LARGE_SAME_DISTANCE = 0.75, 2.0
"""Distances below which two views are of the same thing, in units: for small things, and for LARGE ones."""

LARGE = ("car", "kiosk", "awning", "dumpster", "tree", "shop_sign")

PROBABILITY_FLOOR = 0.02
"""Added to each probability before taking its logarithm, so that a single view cannot exclude anything."""

FULL_WEIGHT_PIXELS, MAX_WEIGHT = 150.0, 4.0
"""Number of pixels of a view with weight 1, and maximum weight of a view."""

_NAMED = np.array([kind not in SURFACES for kind in KINDS])

_SIZES = np.array([len(KINDS), len(COLOURS), *(places.stop - places.start for places in look_slices().values())])
"""Sizes of the groups of mutually exclusive names: kinds, colours, and each group of looks."""

_STARTS = np.concatenate([[0], np.cumsum(_SIZES)])

Floats = npt.NDArray[np.float32]

_Number = TypeVar("_Number", np.float32, np.float64)


class LandmarkBelief(NamedTuple):
    """A landmark with attribute probabilities.

    Attributes:
        mark: place and most likely attributes; always the same object for the same landmark.
        kinds, colours: probabilities, indexed as `vocabulary.KINDS` and `COLOURS`.
        looks: probabilities, indexed as `vocabulary.LOOKS`; they sum to 1 within each group.
    """

    mark: MappedLandmark
    kinds: Floats
    colours: Floats
    looks: Floats


@lru_cache(maxsize=512)
def one_hot_of(label: Label) -> tuple[Floats, Floats, Floats]:
    """Return kinds, colours and looks of a known label as one-hot probabilities."""
    codes = codes_of(label.kind, label.colour, label.look)
    rows = []
    for code, names in zip(codes, (KINDS, COLOURS, LOOKS), strict=True):
        row = np.zeros(len(names), np.float32)
        if code != NONE:
            row[code] = 1.0
        rows.append(row)
    return rows[0], rows[1], rows[2]


class _LandmarkScores:
    """A thing at a place, with weighted sums of log probabilities of its attributes.

    Args:
        x, z: the place.
        sums: whether to sum over views; otherwise only the largest view counts.

    Attributes:
        mark: place and most likely attributes; always the same object.
    """

    def __init__(self, x: float, z: float, *, sums: bool) -> None:
        self.mark = MappedLandmark(Label(""), x, z, math.inf)
        self._sums = np.zeros(_STARTS[-1])
        self._is_summed, self._largest = sums, 0.0
        self._belief: LandmarkBelief | None = None

    def add(self, named: DetectedThing, x: float, z: float, distance: float) -> None:
        """Add a view of the thing."""
        weight = min(MAX_WEIGHT, named.thing.pixels / FULL_WEIGHT_PIXELS)  # Larger views count for more.
        if self._is_summed or weight >= self._largest:
            chances = np.concatenate((named.kinds, named.colours, named.looks)).astype(np.float64)
            own = weight * np.log(chances + PROBABILITY_FLOOR)
            self._sums = self._sums + own if self._is_summed else own
            self._largest, self._belief = weight, None
            self.mark.label = label_of(*self._parts(self._sums))
        if distance < 0.9 * self.mark.nearest:
            self.mark.x, self.mark.z, self.mark.nearest = x, z, distance

    def belief(self) -> LandmarkBelief:
        """Return the thing with its attribute probabilities."""
        if self._belief is None:
            first = _STARTS[:-1]
            raised = np.exp(self._sums - np.repeat(np.maximum.reduceat(self._sums, first), _SIZES))
            shares = (raised / np.repeat(np.add.reduceat(raised, first), _SIZES)).astype(np.float32)
            self._belief = LandmarkBelief(self.mark, *self._parts(shares))
        return self._belief

    @staticmethod
    def _parts(values: npt.NDArray[_Number]) -> tuple[npt.NDArray[_Number], ...]:
        """Split values into those of kinds, colours and looks."""
        return values[: _STARTS[1]], values[_STARTS[1] : _STARTS[2]], values[_STARTS[2] :]


class ProbabilisticLandmarkMemory(LandmarkMemory):
    """Landmarks seen so far: detected things with attribute probabilities; buildings and crossings by label.

    Args:
        labels: labels of the segmentation, by index.
        sums: whether to sum log probabilities over the views of a thing; otherwise its largest view names it.
    """

    def __init__(self, labels: Sequence[Label], *, sums: bool = True) -> None:
        super().__init__(labels)
        self._is_summed = sums
        self.used_labels = frozenset(
            number for number, label in enumerate(labels) if label.kind in ("building", "zebra_crossing")
        )
        self._places: list[_LandmarkScores] = []

    def add(self, sightings: Iterable[Sighting]) -> None:
        """Add a frame's buildings and crossings; things are added by `add_things`."""
        assert self.used_labels is not None
        super().add(sighting for sighting in sightings if sighting.label in self.used_labels)

    def add_things(self, things: Iterable[DetectedThing], pose: tuple[float, float, float]) -> None:
        """Add a frame's things.

        Args:
            things: with their names.
            pose: (x, z, radians clockwise) of the camera in the agent's own frame.
        """
        x, z, heading = pose
        sin, cos = math.sin(heading), math.cos(heading)
        for named in things:
            if not _NAMED[named.kind]:
                continue
            right, ahead = named.thing.right, named.thing.ahead
            self._add(named, x + right * cos + ahead * sin, z - right * sin + ahead * cos, math.hypot(right, ahead))

    def matching(self, thing: Thing) -> list[MappedLandmark]:
        """Return the landmarks whose most likely attributes match the given attributes of a thing."""
        return super().matching(thing) + [
            place.mark for place in self._places if matches_label(thing, place.mark.label)
        ]

    def beliefs(self) -> list[LandmarkBelief]:
        """Return all landmarks with their attribute probabilities."""
        return [*certain_beliefs(self), *(place.belief() for place in self._places)]

    def forget(self) -> None:
        """Remove all landmarks."""
        super().forget()
        self._places.clear()

    def forget_collectibles(self) -> None:
        """Remove all collectibles: each turn has its own."""
        super().forget_collectibles()
        self._places = [place for place in self._places if place.mark.label.kind not in COLLECTIBLES]

    def _add(self, named: DetectedThing, x: float, z: float, distance: float) -> None:
        kind = KINDS[named.kind]
        for place in self._places:
            mark = place.mark
            if abs(mark.x - x) >= LARGE_SAME_DISTANCE:  # Most are; the rest takes longer.
                continue
            apart = LARGE_SAME_DISTANCE if kind in LARGE and mark.label.kind == kind else SAME_DISTANCE
            is_like = (kind in COLLECTIBLES) == (mark.label.kind in COLLECTIBLES)
            if is_like and math.hypot(mark.x - x, mark.z - z) < apart:
                place.add(named, x, z, distance)
                return
        place = _LandmarkScores(x, z, sums=self._is_summed)
        place.add(named, x, z, distance)
        self._places.append(place)


def certain_beliefs(landmarks: LandmarkMemory) -> list[LandmarkBelief]:
    """Return all labelled landmarks, with probability 1 for their labels."""
    return [LandmarkBelief(mark, *one_hot_of(mark.label)) for mark in landmarks.labelled()]

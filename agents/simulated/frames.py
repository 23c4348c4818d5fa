"""Labelled frames from random viewpoints in streets and rooms, for training visual encoders."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from arramon_client.world import COLUMNS, ROWS
from arramon_dataset.generation.navigation_tasks import NavigationTaskSampler
from arramon_dataset.plans import build_section, read_plan
from arramon_server.sim.cameras import Actor, Viewpoint
from arramon_server.sim.catalogue import ALL_TYPES
from arramon_server.sim.city import city_scene
from arramon_server.sim.geometry import Point
from arramon_server.sim.labels import LABELS, places_of
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.room import RoomCell, RoomPosition
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.rules import Collectible, PlacedObject
from arramon_server.sim.section import Section
from arramon_server.sim.view import room_actors, street_actor

UNIT = 0.001
"""Resolution of the camera's depth, in units."""

ROOM_SHARE, PROP_SHARE, ODD_HEADING_SHARE = 0.2, 0.4, 0.15
"""Shares of frames in the room, of street frames that look at furniture, and of headings that are not multiples of 30
degrees, unlike those of agents."""

NEAREST, FARTHEST = 0.6, 11.0
"""Range of distances of collectibles from the viewpoint, in units."""

PROP_RANGE = (1.0, 12.0)
"""Range of distances of the furniture that a viewpoint looks at, in units."""

HALF_VIEW = math.radians(31.0)
"""Half of the angle in which collectibles are placed: a little more than the camera's, so that some are cut off."""

MOST_IN_STREET, MOST_IN_ROOM = 6, 12
JITTER = 0.45
"""Maximum offset of a viewpoint or collectible from a lattice point along each axis, in units."""


@dataclass(frozen=True, eq=False)
class LabelledFrame:
    """A frame and its labels.

    Attributes:
        rgb: (size, size, 3) uint8.
        depth: (size, size) float32, units along the viewing direction; 0 where there is nothing.
        labels: (size, size) uint16, indices in `arramon_server.sim.labels.LABELS`.
    """

    rgb: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.float32]
    labels: npt.NDArray[np.uint16]


class _Street:
    """A section with its camera and the places where agents and collectibles can be, built on first use."""

    def __init__(self, section: Section) -> None:
        self.section = section
        by_kind: dict[str, list[tuple[float, float]]] = {}
        for prop in section.props:
            by_kind.setdefault(prop.kind, []).append((prop.x, prop.z))
        self.props = [np.array(places) for _, places in sorted(by_kind.items())]

    @cached_property
    def camera(self) -> RasterCamera:
        return RasterCamera(city_scene(self.section))

    @cached_property
    def numbers(self) -> npt.NDArray[np.uint16]:
        return places_of(self.camera.labels)

    @cached_property
    def places(self) -> npt.NDArray[np.float64]:
        return NavigationTaskSampler(self.section).places


class FrameSource:
    """Draws labelled frames; the same seed and number give the same frame. Not thread-safe.

    Args:
        sections: id of the plan and seed of the furniture of each section; see `dataset.plans.build_section`.
        size: side length of the frames, in pixels.
        seed: seed of all random choices.
        room_share: share of frames in the room.
    """

    def __init__(
        self, sections: Sequence[tuple[str, str]], size: int, seed: int, room_share: float = ROOM_SHARE
    ) -> None:
        self._streets = [_Street(build_section(read_plan(plan), key)) for plan, key in sections]
        self._size, self._seed, self._room_share = size, seed, room_share
        self._room = RasterCamera(room_scene())
        self._room_numbers = places_of(self._room.labels)

    def frame(self, number: int) -> LabelledFrame:
        """Return a frame by its number."""
        random = np.random.default_rng((self._seed, number))
        if random.random() < self._room_share:
            viewpoint, actors = _in_room(random)
            return self._draw(self._room, self._room_numbers, viewpoint, actors)
        street = self._streets[random.integers(len(self._streets))]
        viewpoint, actors = _in_street(street, random)
        return self._draw(street.camera, street.numbers, viewpoint, actors)

    def _draw(
        self,
        camera: RasterCamera,
        numbers: npt.NDArray[np.uint16],
        viewpoint: Viewpoint,
        actors: Sequence[Actor],
    ) -> LabelledFrame:
        frame = camera.render(viewpoint, actors, self._size, segmentation=True)
        assert frame.segmentation is not None
        return LabelledFrame(frame.rgb, frame.depth.astype(np.float32) * np.float32(UNIT), numbers[frame.segmentation])


def _in_street(street: _Street, random: np.random.Generator) -> tuple[Viewpoint, list[Actor]]:
    places = street.places
    x, z, heading = _viewpoint(street, random)
    right, ahead = _seen_from(places, x, z, heading)
    distance = np.hypot(right, ahead)
    near = np.flatnonzero(
        (ahead > 0) & (distance > NEAREST) & (distance < FARTHEST) & (np.abs(np.arctan2(right, ahead)) < HALF_VIEW)
    )
    count = min(int(random.integers(MOST_IN_STREET + 1)), len(near))
    if not count:
        return Viewpoint(x, z, heading), []
    weights = 1.0 / distance[near] ** 2  # As many at each distance: their number grows with it.
    chosen = random.choice(near, count, replace=False, p=weights / weights.sum())
    actors = []
    for place in places[chosen]:
        at = place + random.uniform(-JITTER, JITTER, 2) * (random.random() < 0.5)
        type_ = ALL_TYPES[random.integers(len(ALL_TYPES))]
        actors.append(street_actor(Collectible(type_, Point(float(at[0]), 0.0, float(at[1])))))
    return Viewpoint(x, z, heading), actors


def _viewpoint(street: _Street, random: np.random.Generator) -> tuple[float, float, float]:
    """Draw a viewpoint (x, z, heading in degrees), often one that looks at furniture of a random kind."""
    places = street.places
    at = places[random.integers(len(places))]
    heading = street.section.heading + 30.0 * int(random.integers(12))
    if random.random() < PROP_SHARE:
        kind = street.props[random.integers(len(street.props))]
        prop = kind[random.integers(len(kind))]
        distance = np.hypot(*(places - prop).T)
        fitting = np.flatnonzero((distance > PROP_RANGE[0]) & (distance < PROP_RANGE[1]))
        if len(fitting):
            weights = 1.0 / distance[fitting] ** 2
            at = places[random.choice(fitting, p=weights / weights.sum())]
            bearing = math.degrees(math.atan2(prop[0] - at[0], prop[1] - at[1]))
            turns = round((bearing - street.section.heading + random.uniform(-20.0, 20.0)) / 30.0)
            heading = street.section.heading + 30.0 * turns
    x, z = (at + random.uniform(-JITTER, JITTER, 2)).tolist()
    if random.random() < ODD_HEADING_SHARE:
        heading = float(random.uniform(0.0, 360.0))
    return x, z, float(heading)


def _seen_from(
    places: npt.NDArray[np.float64], x: float, z: float, heading: float
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return how far places are to the right and ahead of a viewpoint, in units."""
    sin, cos = math.sin(math.radians(heading)), math.cos(math.radians(heading))
    dx, dz = places[:, 0] - x, places[:, 1] - z
    return dx * cos - dz * sin, dx * sin + dz * cos


def _in_room(random: np.random.Generator) -> tuple[Viewpoint, Sequence[Actor]]:
    square = RoomCell(int(random.integers(COLUMNS)), int(random.integers(ROWS)))
    heading = 30.0 * random.integers(12)
    levels: dict[tuple[int, int], int] = {}
    room = []
    for _ in range(random.integers(MOST_IN_ROOM + 1)):
        cell = int(random.integers(COLUMNS)), int(random.integers(ROWS))
        if cell != tuple(square) and levels.get(cell, 0) < 2:
            levels[cell] = levels.get(cell, 0) + 1
            type_ = ALL_TYPES[random.integers(len(ALL_TYPES))]
            room.append(PlacedObject(type_, RoomPosition(cell[0], levels[cell], cell[1])))
    actors = room_actors(tuple(room))
    return Viewpoint(square.column * 1.5, square.row * 1.5, float(heading)), actors


def label_names() -> list[tuple[str, str, str]]:
    """Return (kind, colour, look) of each label, by its index in frames."""
    return [(label.kind, label.colour, label.look) for label in LABELS]

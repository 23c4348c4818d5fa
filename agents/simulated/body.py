"""Simulated agent in a section's streets without images: it perceives by geometry, with errors of a visual encoder."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.ground_map import CELL
from arramon_agents.mapping.motion import STEPS
from arramon_agents.mapping.probabilistic_landmark_memory import ProbabilisticLandmarkMemory
from arramon_agents.perception.eyes.depth_segmentation import FrameThing
from arramon_agents.perception.eyes.detected_things import DetectedThing
from arramon_agents.perception.eyes.predicted_segmentation import LABELS
from arramon_agents.perception.eyes.reach import FAR
from arramon_agents.perception.eyes.vocabulary import COLOURS, KINDS, LOOKS, NONE, look_slices
from arramon_agents.perception.scan import FREE_POINT_DISTANCES, MAX_DISTANCE, SIGHTING_SQUARE, Scan, Sighting
from arramon_agents.simulated.world import FOCAL, StreetWorld, Things
from arramon_agents.simulated.world_frame import WorldFrame
from arramon_agents.vl_map.features import relative_to
from arramon_client.agent import Action
from arramon_client.world import COLLECTIBLE_COLOURS, COLLECTIBLES, FURNITURE

RAYS = 56
"""Number of rays that are cast per frame."""

_RIGHT = ((np.arange(RAYS) + 0.5) * 2.0 / RAYS - 1.0) * math.tan(math.radians(30.0))
_TURNED, _LENGTH = np.arctan(_RIGHT), np.sqrt(1.0 + _RIGHT**2)

CROSSING_SEEN, CROSSING_SAMPLES = 14.0, 30
"""Maximum distance at which zebra crossings are seen without errors, in units; number of samples of such a sighting."""

_BUILDINGS = {label.look: number for number, label in enumerate(LABELS) if label.kind == "building"}
_CROSSING = next(number for number, label in enumerate(LABELS) if label.kind == "zebra_crossing")
_SLICES = look_slices()
_COLLECTIBLES = [KINDS.index(kind) for kind in COLLECTIBLES]
_FURNITURE = [KINDS.index(kind) for kind in FURNITURE]
_LIKE = {
    kind: [KINDS.index(other) for other in group]
    for group in (("stop_sign", "speed_sign"), ("lamp_post", "traffic_light"), ("phone_booth", "kiosk"))
    for kind in group
}


@dataclass(frozen=True, slots=True)
class PerceptionErrorRates:
    """Error rates of a visual encoder, 0 for a perfect one; the defaults were measured on frames of `train`.

    Attributes:
        missed: share of views of small things that are missed; it is lower for large things.
        kind, colour, pattern, shape: shares of things, and of views, with a wrong attribute.
        facade: share of buildings with a wrong facade.
        unclear: share of views of walls without a facade, per unit of distance.
        place, displaced: standard deviation of a thing's position, as a share of its distance; share of views with a
            gross position error.
        crossing: relative reduction of the distance at which zebra crossings are seen, and standard deviation of their
            positions, in units.
    """

    missed: float = 0.22
    kind: float = 0.03
    colour: float = 0.015
    pattern: float = 0.01
    shape: float = 0.3
    facade: float = 0.03
    unclear: float = 0.012
    place: float = 0.025
    displaced: float = 0.04
    crossing: float = 0.3

    def scaled(self, share: float) -> "PerceptionErrorRates":
        """Return these error rates times a factor."""
        return PerceptionErrorRates(*(min(0.9, share * getattr(self, name)) for name in self.__slots__))


class SimulatedBody(AgentBody):
    """Odometry, map and landmarks of an agent that walks in a simulated section.

    Args:
        world: streets of the section.
        things: things in the section.
        pose: initial pose in the world (x, z, heading in radians).
        faults: error rates of perception.
        random: random generator of the errors.

    Attributes:
        frame: its initial pose in the world.
    """

    def __init__(
        self,
        world: StreetWorld,
        things: Things,
        pose: tuple[float, float, float],
        faults: PerceptionErrorRates,
        random: np.random.Generator,
    ) -> None:
        super().__init__(LABELS, ProbabilisticLandmarkMemory(LABELS))
        self._world, self._things, self._faults, self._random = world, things, faults, random
        self.frame = WorldFrame(*pose)
        self._confused = random.random((len(things.codes), 3))
        self._wrong = [self._drawn_names(number) for number in range(len(things.codes))]
        looks = [look for look in _BUILDINGS if look]
        self._facades = [
            looks[random.integers(len(looks))] if random.random() < faults.facade else building.facade
            for building in world.section.buildings
        ]

    @property
    def world_pose(self) -> tuple[float, float, float]:
        """The pose (x, z, heading in radians) in the world."""
        return self.frame.pose_of(self)

    def begin_turn(self, things: Things) -> None:
        """Begin a turn of the episode, with other collectibles.

        Args:
            things: the same furniture, then the collectibles of the turn.
        """
        kept = int((~self._things.is_collectible).sum())
        self._things = things
        added = len(things.codes) - kept
        self._confused = np.concatenate([self._confused[:kept], self._random.random((added, 3))])
        self._wrong = self._wrong[:kept] + [self._drawn_names(number) for number in range(kept, len(things.codes))]
        self.record_action(None)
        self.landmarks.forget_collectibles()

    def apply(self, action: Action) -> None:
        """Carry out an action; a step has no effect if it is blocked."""
        self.record_action(action)
        blocked = False
        if action is Action.FORWARD:
            sin, cos = STEPS[self.heading]
            here, there = self.frame.to_world(self.x, self.z), self.frame.to_world(self.x + sin, self.z + cos)
            blocked = not self._world.is_free(*here, *there)
        self._move(blocked)

    def observe(self) -> None:
        """Update map and landmarks by what is seen from the current pose."""
        x, z, heading = self.world_pose
        solid, wall, house = self._world.cast(x, z, heading + _TURNED, MAX_DISTANCE * 1.1)
        solid, wall = solid / _LENGTH, wall / _LENGTH  # Distances ahead.
        own = self.x, self.z, self.angle
        self.ground.add(_scan(solid, wall, own))
        self.landmarks.add(self._sightings(wall, house, own, (x, z)))
        self.landmarks.add_things(self._named(x, z, heading), own)

    def _sightings(
        self,
        wall: npt.NDArray[np.float64],
        house: npt.NDArray[np.int64],
        own: tuple[float, float, float],
        place: tuple[float, float],
    ) -> list[Sighting]:
        """Return sightings of buildings (with facade) along the rays, and of zebra crossings in view."""
        found = []
        hit = np.flatnonzero(np.isfinite(wall))
        unclear = self._random.random(len(self._facades))[house[hit] - 1] < self._faults.unclear * wall[hit]
        labels = np.array([_BUILDINGS[self._facades[number - 1]] for number in house[hit]], np.int64)
        if len(hit):
            labels[unclear] = _BUILDINGS[""]
            points = _to_own(_RIGHT[hit] * wall[hit], wall[hit], own)
            keys: dict[tuple[int, int, int], list[int]] = {}
            for number, (label, cell) in enumerate(
                zip(labels.tolist(), np.floor(points / SIGHTING_SQUARE).astype(int), strict=True)
            ):
                keys.setdefault((label, int(cell[0]), int(cell[1])), []).append(number)
            for (label, _, _), numbers in keys.items():
                x, z = points[numbers].mean(0).tolist()
                found.append(Sighting(label, x, z, math.hypot(x - own[0], z - own[1]), 2 * len(numbers)))
        things = self._things
        if things.is_crossing.any():
            places, reach = things.places[things.is_crossing], CROSSING_SEEN * (1.0 - self._faults.crossing)
            right, ahead = relative_to(places, (*place, self.world_pose[2]))
            shown = (ahead > 0.5) & (np.abs(right) < ahead * 0.6) & (np.hypot(right, ahead) < reach)
            shown &= self._world.are_in_sight(*place, places)
            for number in np.flatnonzero(shown).tolist():
                x, z = _to_own(right[number : number + 1], ahead[number : number + 1], own)[0].tolist()
                x, z = (np.array([x, z]) + self._random.normal(0.0, self._faults.crossing, 2)).tolist()
                far = float(np.hypot(right[number], ahead[number]))
                found.append(Sighting(_CROSSING, x, z, far, CROSSING_SAMPLES))
        return found

    def _named(self, x: float, z: float, heading: float) -> list[DetectedThing]:
        """Return the things in view as the visual encoder would cut them out and name them."""
        things, random = self._things, self._random
        right, ahead = relative_to(things.places, (x, z, heading))
        shown = (ahead > 0.4) & (ahead < FAR.ahead) & (np.abs(right) < ahead * math.tan(math.radians(30.0)))
        shown &= ~things.is_crossing
        away = np.arctan2(x - things.places[:, 0], z - things.places[:, 1])
        with np.errstate(invalid="ignore"):
            shown &= ~(np.cos(away - things.faces) < 0.15)
        numbers = np.flatnonzero(shown)
        if len(numbers):
            numbers = numbers[self._world.are_in_sight(x, z, things.places[numbers])]
        found = []
        for number in numbers.tolist():
            far = float(ahead[number])
            width, height = things.sizes[number]
            pixels = int(0.55 * width * min(height, far * 0.57 + 0.5) * (FOCAL / far) ** 2)
            missed = self._faults.missed * (1.0 if pixels < 60 else 0.35 if pixels < 200 else 0.05)
            if pixels < FAR.pixels or random.random() < missed:
                continue
            error = random.normal(0.0, self._faults.place * far, 2)
            if random.random() < self._faults.displaced:
                error += random.normal(0.0, 0.5, 2)
            near = far - min(0.3, 0.3 * width)
            box = FrameThing(
                slice(0, 1), slice(0, 1), np.ones(min(pixels, 700), np.bool_),
                float(right[number] * near / far + error[0]), float(near + error[1]),
                width, float(things.low[number]), float(things.low[number] + height),
            )  # fmt: skip
            found.append(DetectedThing(box, *self._names(number, pixels)))
        return found

    def _names(self, number: int, pixels: int) -> tuple[npt.NDArray[np.float32], ...]:
        """Return probabilities of kinds, colours and looks of a thing from one view."""
        faults, random = self._faults, self._random
        codes, wrong = self._things.codes[number], self._wrong[number]
        worse = 0.8 + math.exp(-pixels / 60.0)
        shares = faults.kind, faults.colour, self._look_share(codes.look)
        found = []
        for part, (code, other, share, names) in enumerate(
            zip(codes, wrong, shares, (KINDS, COLOURS, LOOKS), strict=True)
        ):
            row = np.full(len(names), 1e-3, np.float32)
            if code != NONE:
                # Half of the errors are the same in all views of a thing, the others differ between views.
                is_wrong = self._confused[number, part] < 0.5 * share * worse or random.random() < 0.5 * share * worse
                sure = 0.99 - random.random() ** 6 * (0.5 if share > 0.0 else 0.0)
                row[other if is_wrong else code] = sure
                row[code if is_wrong else other] += 0.6 * (1.0 - sure)
            found.append(row / row.sum() if part < 2 else _grouped(row))
        return tuple(found)

    def _look_share(self, look: int) -> float:
        if look != NONE and LOOKS[look][0] == "shape":
            return self._faults.shape
        return self._faults.pattern

    def _drawn_names(self, number: int) -> tuple[int, int, int]:
        """Draw a kind, a colour and a look with which a thing is confused."""
        random, codes = self._random, self._things.codes[number]
        kinds = _LIKE.get(KINDS[codes.kind], _COLLECTIBLES if codes.kind in _COLLECTIBLES else _FURNITURE)
        look = NONE
        if codes.look != NONE:
            places = _SLICES[LOOKS[codes.look][0]]
            look = int(random.integers(places.start, places.stop))
        return int(random.choice(kinds)), int(random.integers(len(COLLECTIBLE_COLOURS))), look


def _grouped(row: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    for places in _SLICES.values():
        row[places] /= row[places].sum()
    return row


def _scan(solid: npt.NDArray[np.float64], wall: npt.NDArray[np.float64], own: tuple[float, float, float]) -> Scan:
    """Return obstacles and free ground of a frame from ray distances, like `perception.scan.Eye.scan` from images."""
    near = np.minimum(solid, MAX_DISTANCE)
    points, walls = [], []
    for distance, is_wall in ((solid, False), (wall, True)):
        hit = np.flatnonzero(distance < MAX_DISTANCE)
        points.append(_to_own(_RIGHT[hit] * distance[hit], distance[hit], own))
        at_wall = np.full(len(hit), is_wall) if is_wall else np.isclose(distance[hit], wall[hit], atol=CELL)
        walls.append(at_wall)
    columns, steps = np.nonzero(FREE_POINT_DISTANCES[None, :] < near[:, None])
    ahead = FREE_POINT_DISTANCES[steps]
    free = _to_own(_RIGHT[columns] * ahead, ahead, own)
    return Scan(np.concatenate(points).astype(np.float32), np.concatenate(walls), free.astype(np.float32))


def _to_own(
    right: npt.NDArray[np.floating], ahead: npt.NDArray[np.floating], own: tuple[float, float, float]
) -> npt.NDArray[np.float64]:
    x, z, heading = own
    sin, cos = math.sin(heading), math.cos(heading)
    return np.stack([x + right * cos + ahead * sin, z - right * sin + ahead * cos], axis=1)

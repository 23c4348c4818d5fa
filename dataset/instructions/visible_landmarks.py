"""Landmarks along a path: which ones the camera shows large enough to recognise, from which poses, and where.

Landmarks have the identities of the scene and the street graph, so that phrases can be checked against the world.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from arramon_client.world import COLLECTIBLES, EYE_HEIGHT, FIELD_OF_VIEW, Action
from arramon_dataset.instructions.openings import openings
from arramon_dataset.plans.graph import NamedBuilding, StreetGraph
from arramon_server.sim.assets.roadside import ZEBRA_LENGTH, ZEBRA_WIDTH
from arramon_server.sim.cameras import Camera, Frame, Viewpoint, colourless
from arramon_server.sim.city import label_of_prop
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import SegmentationLabel
from arramon_server.sim.raster.compilation import cached
from arramon_server.sim.rules import Collectible, moved
from arramon_server.sim.scene import Scene
from arramon_server.sim.section import Section
from arramon_server.sim.view import street_actor

SIZE = 224
"""Side length of the frames in which landmarks must be recognisable, in pixels: the server's default."""

MIN_PIXELS, MIN_ROWS = 90, 7
"""Minimum numbers of pixels and of pixel rows at which a person recognises a thing.

Johnson's criteria ask for 6 to 8 lines across the lesser side of a thing to recognise it, and frames of this world
agree: with 90 pixels a hydrant has its caps and a bin its lid, with 40 both are a dab of colour."""

MIN_PIXELS_OF = {
    "building": 1200, "banner": 180, "shop_sign": 220, "speed_sign": 180, "zebra_crossing": 180, "bags": 130,
    "tyre_stack": 130, "kiosk": 130, "dumpster": 130, "barrier": 130, "car": 130, **dict.fromkeys(COLLECTIBLES, 45),
}  # fmt: skip
"""Minimum number of pixels by kind. Signs, banner shapes, facades, and long, low or colourless things need more;
collectibles, recognised by colour and pattern, need fewer."""

MIN_ROWS_OF = {"zebra_crossing": 3, **dict.fromkeys(COLLECTIBLES, 5)}
"""Minimum number of pixel rows of flat or small kinds."""

MIN_GLIMPSE = 12
"""Minimum number of pixels of a thing that can be confused with a landmark: an agent detects that few."""

EVERY, LAST = 2, 6
"""Frames are rendered from every second pose of a path, and from each of the last six."""

SLACK = 1.0
"""Maximum distance between a pixel and the collectible that it is assigned to, in units, if several look the same."""

CORNER_SEEN, JUNCTION_SEEN = 12.0, 16.0
"""Maximum distances from which a corner and a junction are recognised, in units."""


@dataclass(frozen=True, slots=True)
class Landmark:
    """A piece of furniture, a collectible, a building, or a place in the street.

    Attributes:
        label: what it looks like. For an opening the kind is "intersection" and the look is its side as seen along the
            path, "left" or "right"; for a junction the kind is "junction" and the look one of `graph.JUNCTIONS`; for a
            corner of a block it is "corner".
        x, z: position in the world frame, in units; for a building the middle of the wall nearest to the path.
        seen: indices of the poses from which it is recognised, in order; -1 for a look around at the first pose. If
            empty, it is never mentioned, but may be confused with another.
        glimpsed: index of the first pose from which at least MIN_GLIMPSE pixels are visible; None if there is none.
        identity: the name of its body in the scene ("cone/3", "building/12"), its identity in the street graph
            ("junction/2", "corner/7"), or "collectible/" and its place among the turn's. An opening has that of its
            junction, or "" without a graph.
        pixels: how many pixels of a frame of SIZE it covers, for each of `seen`; 0 for places.
        heading: direction of its front in degrees; of a zebra crossing, that of the street. 0 for all but furniture.
    """

    label: SegmentationLabel
    x: float
    z: float
    seen: tuple[int, ...]
    glimpsed: int | None = None
    identity: str = ""
    pixels: tuple[int, ...] = ()
    heading: float = 0.0

    def covers_ground(self, x: float, z: float, margin: float) -> bool:
        """Return whether it is a zebra crossing and (x, z) is on it or within `margin` units of its edges."""
        if self.label.kind != "zebra_crossing":
            return False
        across, along = Pose(self.x, self.z, self.heading).local(x, z)
        return abs(across) <= ZEBRA_WIDTH / 2 + margin and abs(along) <= ZEBRA_LENGTH / 2 + margin


def with_names_as_labels(scene: Scene) -> Scene:
    """Return a section's scene with each body's name as its label, for the camera of `find_landmarks`."""
    return replace(scene, bodies=tuple(replace(body, label=body.name) for body in scene.bodies))


def poses_along(start: Pose, path: Sequence[tuple[float, float]], actions: Sequence[Action]) -> list[Pose]:
    """Return the poses of a ground truth, the start included. Positions are those of the path; turns repeat one.

    Raises:
        ValueError: unless there is exactly one forward action for each step of the path.
    """
    poses, place = [Pose(*path[0], start.heading)], 0
    for action in actions:
        pose = moved(poses[-1], action)
        if action is Action.FORWARD:
            place += 1
            if place >= len(path):
                raise ValueError(f"the actions step forward more often than the path's {len(path) - 1} steps")
            pose = Pose(*path[place], pose.heading)
        poses.append(pose)
    if place != len(path) - 1:
        raise ValueError(f"the actions step forward {place} times; the path has {len(path) - 1} steps")
    return poses


def find_landmarks(
    poses: Sequence[Pose],
    street: Sequence[Collectible],
    section: Section,
    camera: Camera,
    graph: StreetGraph | None = None,
) -> tuple[Landmark, ...]:
    """Return all landmarks, with the poses from which each is recognised; at the first pose in all directions.

    Args:
        poses: in order.
        street: the collectibles in the street.
        section: whose furniture is included.
        camera: of the section's scene, `with_names_as_labels`.
        graph: of the section's streets; None to leave out buildings, junctions and corners.
    """
    things = _things(poses, street, section, graph)
    places = _places_of(graph)
    actors = [street_actor(item) for item in street]
    sightings = _Sightings(camera.labels, things)
    visible: list[list[int]] = [[] for _ in places]
    positions = np.array([(place.x, place.z) for place in places]).reshape(-1, 2)
    farthest = np.array([CORNER_SEEN if place.label.kind == "corner" else JUNCTION_SEEN for place in places])
    round_about = [poses[0].turned(60.0 * i) for i in range(1, 6)]
    walked = [(n, pose) for n, pose in enumerate(poses) if n % EVERY == 0 or n >= len(poses) - LAST]
    for number, pose in [*((-1, pose) for pose in round_about), *walked]:
        frame = camera.render(
            Viewpoint(pose.x, pose.z, pose.heading), actors, SIZE, segmentation=True, into=colourless(SIZE)
        )
        sightings.add(number, pose, frame)
        for index in _seen_places(positions, farthest, pose, frame):
            if visible[index][-1:] != [number]:
                visible[index].append(number)
    landmarks = [
        replace(place, seen=tuple(seen), glimpsed=seen[0] if seen else None, pixels=(0,) * len(seen))
        for place, seen in zip(places, visible, strict=True)
    ]
    return (*sightings.landmarks(), *landmarks, *_openings(poses, section, graph))


def _things(
    poses: Sequence[Pose], street: Sequence[Collectible], section: Section, graph: StreetGraph | None
) -> list[Landmark]:
    """Return the landmarks with visible bodies, without sightings: furniture, collectibles and buildings."""
    counts: dict[str, int] = {}
    found = []
    for prop in section.props:
        number = counts[prop.kind] = counts.get(prop.kind, -1) + 1
        identity = f"{prop.kind}/{number}"
        found.append(Landmark(label_of_prop(prop), prop.x, prop.z, (), identity=identity, heading=prop.heading))
    for number, item in enumerate(street):
        x, z = item.position.x, item.position.z
        found.append(Landmark(SegmentationLabel.of(item.type), x, z, (), identity=f"collectible/{number}"))
    passed = np.array([(pose.x, pose.z) for pose in poses])
    for building in () if graph is None else graph.buildings:
        x, z = _nearest_wall(building, passed)
        found.append(Landmark(SegmentationLabel("building", look=building.look), x, z, (), identity=building.identity))
    return found


def _places_of(graph: StreetGraph | None) -> list[Landmark]:
    """Return the junctions and corners of a graph, without sightings."""
    if graph is None:
        return []
    junctions = [
        Landmark(SegmentationLabel("junction", look=j.kind), j.x, j.z, (), identity=j.identity) for j in graph.junctions
    ]
    return [
        *junctions,
        *(Landmark(SegmentationLabel("corner"), c.x, c.z, (), identity=c.identity) for c in graph.corners),
    ]


def _nearest_wall(building: NamedBuilding, places: npt.NDArray[np.float64]) -> tuple[float, float]:
    """Return the middle of the wall that is nearest to any of the places, (n, 2)."""
    corners = np.array(building.corners)
    middles = (corners + np.roll(corners, -1, axis=0)) / 2
    squares = np.square(middles[:, None] - places).sum(axis=2)
    x, z = middles[squares.min(axis=1).argmin()].tolist()
    return x, z


class _Sightings:
    """Sightings of each thing in the frames so far.

    Args:
        names: of the camera's labels: bodies' names, and types of collectibles.
        things: landmarks without sightings.
    """

    def __init__(self, names: Sequence[str], things: Sequence[Landmark]) -> None:
        self._things = things
        by_name: dict[str, list[int]] = {}
        for number, thing in enumerate(things):
            label = thing.label
            is_body = not thing.identity.startswith("collectible/")
            name = thing.identity if is_body else f"{label.look} {label.colour} {label.kind}"
            by_name.setdefault(name, []).append(number)
        self._by_number = [np.array(by_name.get(name, ()), dtype=np.int64) for name in names]
        self._places = np.array([(thing.x, thing.z) for thing in things]).reshape(-1, 2)
        self._seen: list[dict[int, int]] = [{} for _ in things]
        self._glimpsed: dict[int, int] = {}

    def add(self, number: int, pose: Pose, frame: Frame) -> None:
        """Add the frame from the pose with this number."""
        assert frame.segmentation is not None
        flat = frame.segmentation.ravel()
        counts, first, last = np.zeros((3, len(self._by_number)), np.int32)
        _find_extents(flat, counts, first, last)
        for label in np.flatnonzero(counts >= MIN_GLIMPSE).tolist():
            candidates = self._by_number[label]
            if not len(candidates):
                continue
            if len(candidates) == 1:
                self._add(number, int(candidates[0]), int(counts[label]), int(first[label]), int(last[label]))
                continue
            pixels = np.flatnonzero(flat == label)
            rows, columns = np.divmod(pixels, SIZE)
            x, z = _ground_positions(pose, frame.depth[rows, columns], columns)
            apart = np.hypot(x[:, None] - self._places[candidates, 0], z[:, None] - self._places[candidates, 1])
            owner = np.where(apart.min(axis=1) < SLACK, candidates[apart.argmin(axis=1)], -1)
            for thing in candidates.tolist():
                own = pixels[owner == thing]
                if len(own):
                    self._add(number, thing, len(own), int(own[0]), int(own[-1]))

    def _add(self, number: int, thing: int, pixels: int, first: int, last: int) -> None:
        """Add a sighting of a thing: its number of pixels in one frame, and the first and last of them, row by row."""
        if pixels < MIN_GLIMPSE:
            return
        self._glimpsed.setdefault(thing, number)
        if is_recognisable(self._things[thing].label.kind, pixels, last // SIZE - first // SIZE + 1):
            self._seen[thing][number] = max(pixels, self._seen[thing].get(number, 0))

    def landmarks(self) -> list[Landmark]:
        """Return all things with their sightings."""
        return [
            replace(thing, seen=tuple(seen), pixels=tuple(seen.values()), glimpsed=self._glimpsed.get(number))
            for number, (thing, seen) in enumerate(zip(self._things, self._seen, strict=True))
        ]


@cached
def _find_extents(
    flat: npt.NDArray[np.uint16],
    counts: npt.NDArray[np.int32],
    first: npt.NDArray[np.int32],
    last: npt.NDArray[np.int32],
) -> None:
    """Count the pixels of each label, and find the first and the last of them.

    Args:
        flat: (pixels,), the label of each, row by row.
        counts, first, last: (labels,) output, zeros before.
    """
    for pixel in range(len(flat)):
        label = flat[pixel]
        if counts[label] == 0:
            first[label] = pixel
        counts[label] += 1
        last[label] = pixel


def is_recognisable(kind: str, pixels: int, rows: int) -> bool:
    """Return whether a person recognises a thing with this many pixels and pixel rows in a frame of SIZE."""
    return pixels >= MIN_PIXELS_OF.get(kind, MIN_PIXELS) and rows >= MIN_ROWS_OF.get(kind, MIN_ROWS)


def _focal() -> float:
    """Return the focal length of a frame of SIZE, in pixels."""
    return SIZE / 2 / math.tan(math.radians(FIELD_OF_VIEW / 2))


def _ground_positions(
    pose: Pose, depth: npt.NDArray[np.uint16], columns: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the x and z of the points shown by pixels with these depths and columns, (n,) each."""
    ahead = depth / 1000.0
    right = ahead * (columns + 0.5 - SIZE / 2) / _focal()
    angle = math.radians(pose.heading)
    return (
        pose.x + right * math.cos(angle) + ahead * math.sin(angle),
        pose.z - right * math.sin(angle) + ahead * math.cos(angle),
    )


def _seen_places(
    positions: npt.NDArray[np.float64], farthest: npt.NDArray[np.float64], pose: Pose, frame: Frame
) -> list[int]:
    """Return the indices of the places in the street that are near enough and not occluded.

    Args:
        positions: (n, 2), of the places.
        farthest: (n,) maximum distances from which they are seen.
        pose: of the camera.
        frame: its frame.
    """
    angle = math.radians(pose.heading)
    dx, dz = (positions - (pose.x, pose.z)).T
    right = dx * math.cos(angle) - dz * math.sin(angle)
    ahead = dx * math.sin(angle) + dz * math.cos(angle)
    near = np.flatnonzero((ahead > 0.5) & (np.hypot(right, ahead) <= farthest))
    right, ahead = right[near], ahead[near]
    columns = np.floor(SIZE / 2 + _focal() * right / ahead).astype(np.int64)
    rows = np.minimum(np.floor(SIZE / 2 + _focal() * EYE_HEIGHT / ahead), SIZE - 1).astype(np.int64)
    inside = (columns >= 0) & (columns < SIZE)
    depth = frame.depth[rows[inside], columns[inside]]
    # The pixel may show a point of the wall or ground a little nearer than the place itself.
    is_seen = (depth / 1000.0 >= 0.9 * ahead[inside] - 0.3) | (depth == 0)
    found: list[int] = near[inside][is_seen].tolist()
    return found


def _openings(poses: Sequence[Pose], section: Section, graph: StreetGraph | None) -> list[Landmark]:
    """Return the openings along the path, each visible from the whole leg that it is on."""
    path: list[tuple[float, float]] = []
    arrivals: list[int] = []
    for number, pose in enumerate(poses):
        if not path or path[-1] != (pose.x, pose.z):
            path.append((pose.x, pose.z))
            arrivals.append(number)
    found = []
    for opening in openings(path, section):
        junction = None if graph is None else graph.junction_at(opening.x, opening.z)
        seen = tuple(range(arrivals[opening.first], arrivals[opening.last] + 1))
        found.append(
            Landmark(
                SegmentationLabel("intersection", look=opening.side),
                opening.x,
                opening.z,
                seen,
                arrivals[opening.first],
                "" if junction is None else junction.identity,
                (0,) * len(seen),
            )
        )
    return found

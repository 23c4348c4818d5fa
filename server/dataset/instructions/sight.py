"""Visibility of landmarks along a path, by the camera's segmentation: which are seen, from which poses, and where."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from server.dataset.instructions.sight_openings import openings
from server.sim.cameras import FIELD_OF_VIEW, Actor, Camera, Viewpoint
from server.sim.city import label_of_prop
from server.sim.geometry import Pose
from server.sim.labels import Label
from server.sim.rules import Action, Collectible, moved
from server.sim.section import Section
from server.sim.view import street_actor

SIZE = 128
"""Side length of the rendered frames, in pixels."""

MIN_PIXELS, MIN_GLIMPSE = 8, 4
"""Minimum number of pixels to be seen, and to be confusable with another landmark."""

SLACK = 1.0
"""Maximum distance between a pixel and the landmark of its label that it is assigned to, in units."""


@dataclass(frozen=True, slots=True)
class Landmark:
    """A piece of furniture, a collectible, or a place where a street opens.

    Attributes:
        label: what it looks like. For an opening the kind is "intersection" and the look is its side as seen along the
            path, "left" or "right".
        x, z: position in the world frame, in units.
        seen: indices of the poses from which it is seen, in order; -1 for a look around at the first pose. If empty, it
            is not mentioned, but may be confused with another.
        glimpsed: index of the first pose from which at least a few pixels of it are seen; None if there is none.
    """

    label: Label
    x: float
    z: float
    seen: tuple[int, ...]
    glimpsed: int | None = None


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
    poses: Sequence[Pose], street: Sequence[Collectible], section: Section, camera: Camera
) -> tuple[Landmark, ...]:
    """Return all landmarks, with the poses from which each is seen; at the first pose in all directions.

    Args:
        poses: in order.
        street: the collectibles in the street.
        section: whose furniture is included.
        camera: of the section's scene.
    """
    labels = [label_of_prop(prop) for prop in section.props] + [Label.of(item.type) for item in street]
    places = np.array([(p.x, p.z) for p in section.props] + [(c.position.x, c.position.z) for c in street])
    by_number = _by_number(labels, camera.labels)
    actors = [street_actor(item) for item in street]
    seen: list[list[int]] = [[] for _ in labels]
    glimpsed: dict[int, int] = {}
    round_about = [poses[0].turned(60.0 * i) for i in range(1, 6)]
    for number, pose in [*((-1, pose) for pose in round_about), *enumerate(poses)]:
        for thing, pixels in _in_frame(pose, actors, camera, by_number, places):
            glimpsed.setdefault(thing, number)
            if pixels >= MIN_PIXELS and (not seen[thing] or seen[thing][-1] != number):
                seen[thing].append(number)
    things = [
        Landmark(label, float(x), float(z), tuple(numbers), glimpsed.get(thing))
        for thing, (label, (x, z), numbers) in enumerate(zip(labels, places.tolist(), seen, strict=True))
    ]
    return (*things, *_places(poses, section))


def _places(poses: Sequence[Pose], section: Section) -> list[Landmark]:
    """Return the openings along the path, each visible from the whole leg that it is on."""
    path: list[tuple[float, float]] = []
    arrivals: list[int] = []
    for number, pose in enumerate(poses):
        if not path or path[-1] != (pose.x, pose.z):
            path.append((pose.x, pose.z))
            arrivals.append(number)
    return [
        Landmark(
            Label("intersection", look=opening.side),
            opening.x,
            opening.z,
            tuple(range(arrivals[opening.first], arrivals[opening.last] + 1)),
            arrivals[opening.first],
        )
        for opening in openings(path, section)
    ]


def _by_number(
    labels: Sequence[Label], camera_labels: Sequence[str]
) -> list[np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Return, for each label number of the camera, the indices of the landmarks with that label."""
    names = [str(label) for label in labels]
    collectibles = {str(label): f"{label.look} {label.colour} {label.kind}" for label in labels}
    return [
        np.array([i for i, name in enumerate(names) if seen in (name, collectibles[name])], dtype=np.int64)
        for seen in camera_labels
    ]


def _in_frame(
    pose: Pose,
    actors: Sequence[Actor],
    camera: Camera,
    by_number: Sequence[np.ndarray[tuple[int], np.dtype[np.int64]]],
    places: np.ndarray[tuple[int, int], np.dtype[np.float64]],
) -> list[tuple[int, int]]:
    """Return (index, pixels) of the landmarks of which at least a few pixels are seen in the frame from `pose`."""
    frame = camera.render(Viewpoint(pose.x, pose.z, pose.heading), actors, SIZE, segmentation=True)
    assert frame.segmentation is not None
    is_thing = np.array([len(things) > 0 for things in by_number])
    rows, columns = np.nonzero(is_thing[frame.segmentation])
    numbers, ahead = frame.segmentation[rows, columns], frame.depth[rows, columns] / 1000.0
    right = ahead * (columns + 0.5 - SIZE / 2) / (SIZE / 2 / math.tan(math.radians(FIELD_OF_VIEW / 2)))
    angle = math.radians(pose.heading)
    x = pose.x + right * math.cos(angle) + ahead * math.sin(angle)
    z = pose.z - right * math.sin(angle) + ahead * math.cos(angle)
    found: list[tuple[int, int]] = []
    for number in np.flatnonzero(np.bincount(numbers) >= MIN_GLIMPSE).tolist():
        things, shown = by_number[number], numbers == number
        apart = np.hypot(x[shown][:, None] - places[things, 0], z[shown][:, None] - places[things, 1])
        nearest = apart.argmin(axis=1)[apart.min(axis=1) < SLACK]
        pixels = np.bincount(nearest, minlength=len(things))
        found += [(int(things[i]), int(pixels[i])) for i in np.flatnonzero(pixels >= MIN_GLIMPSE)]
    return found

"""What the camera's segmentation shows along a path: which things are really seen, from where, and where they stand."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from server.episodes.instruct.sight_openings import openings
from server.sim.cameras import FIELD_OF_VIEW, Actor, Camera, Viewpoint
from server.sim.city import label_of_prop
from server.sim.geometry import Pose
from server.sim.labels import Label
from server.sim.rules import Action, Collectible, moved
from server.sim.section import Section
from server.sim.view import street_actor

SIZE = 128
"""Pixels along each side of the frames that are looked at."""

FEWEST, GLIMPSE = 8, 4
"""Pixels that make a thing seen, and those by which it may be taken for another."""

SLACK = 1.0
"""A pixel belongs to the nearest thing of its label that is no farther than this from it, in units."""


@dataclass(frozen=True, slots=True)
class Landmark:
    """A piece of furniture, a collectible, or a place where a street opens.

    Attributes:
        label: what it looks like; a place's kind is "intersection", its look the side that it opens to, "left" or
            "right", for one who comes along the path.
        x, z: where it stands, in the world frame.
        seen: the numbers of the poses from which it is seen, in order; -1 for a look round at the first. None
            where it is never seen: such a one is not spoken of, but could be mistaken for another.
        glimpsed: the number of the first pose from which at least a little of it is seen; None where there is none.
    """

    label: Label
    x: float
    z: float
    seen: tuple[int, ...]
    glimpsed: int | None = None


def poses_along(start: Pose, path: Sequence[tuple[float, float]], actions: Sequence[Action]) -> list[Pose]:
    """The poses of a ground truth, the start included; positions are those of the path, turns repeat one.

    Raises:
        ValueError: unless there is a forward step for each step of the path.
    """
    poses, place = [Pose(*path[0], start.heading)], 0
    for action in actions:
        pose = moved(poses[-1], action)
        if action is Action.FORWARD:
            place += 1
            if place >= len(path):
                raise ValueError(f"the actions go forward more than the path's {len(path) - 1} times")
            pose = Pose(*path[place], pose.heading)
        poses.append(pose)
    if place != len(path) - 1:
        raise ValueError(f"the actions go forward {place} times, the path {len(path) - 1} times")
    return poses


def look(
    poses: Sequence[Pose], street: Sequence[Collectible], section: Section, camera: Camera
) -> tuple[Landmark, ...]:
    """Everything in the section, and how it is seen from the poses, and from the first in all directions.

    Args:
        poses: in order.
        street: the collectibles in the street.
        section: whose furniture is looked for.
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
            if pixels >= FEWEST and (not seen[thing] or seen[thing][-1] != number):
                seen[thing].append(number)
    things = [
        Landmark(label, float(x), float(z), tuple(numbers), glimpsed.get(thing))
        for thing, (label, (x, z), numbers) in enumerate(zip(labels, places.tolist(), seen, strict=True))
    ]
    return (*things, *_places(poses, section))


def _places(poses: Sequence[Pose], section: Section) -> list[Landmark]:
    """The openings along the way, each in view from the whole of the leg that it lies on."""
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
    """For each of the camera's numbers the things that have its label."""
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
    """(number, pixels) of the things that at least a little is seen of in the frame from `pose`."""
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
    for number in np.flatnonzero(np.bincount(numbers) >= GLIMPSE).tolist():
        things, shown = by_number[number], numbers == number
        apart = np.hypot(x[shown][:, None] - places[things, 0], z[shown][:, None] - places[things, 1])
        nearest = apart.argmin(axis=1)[apart.min(axis=1) < SLACK]
        pixels = np.bincount(nearest, minlength=len(things))
        found += [(int(things[i]), int(pixels[i])) for i in np.flatnonzero(pixels >= GLIMPSE)]
    return found

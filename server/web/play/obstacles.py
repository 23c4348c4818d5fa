"""What stands in a person's way: the solid body that blocked a step, and on which side of them it is."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from arramon_client.world import AGENT_RADIUS, STEP
from arramon_server.sim.footprints import Footprint
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import LABELS, SegmentationLabel
from arramon_server.sim.scene import Body

AHEAD = 0.1
"""Largest offset to a side, in units, of a place that counts as straight ahead."""

_LABELS = {str(label): label for label in LABELS}


@dataclass(frozen=True, slots=True)
class Obstacle:
    """The body that blocks a step.

    Attributes:
        label: its segmentation label.
        side: "left", "ahead" or "right", as seen by the person.
    """

    label: SegmentationLabel
    side: str


def find_obstacle(bodies: Iterable[Body], pose: Pose) -> Obstacle | None:
    """Return the body nearest to the way of a step forward; None if the way is free.

    Args:
        bodies: bodies of the street.
        pose: where the person stands and looks.
    """
    after = pose.ahead(STEP)
    start, end = (pose.x, pose.z), (after.x, after.z)
    found: tuple[float, Body, Footprint] | None = None
    for body in bodies:
        if body.collider is None or not _is_near(body, pose):
            continue
        footprint = Footprint.of(body)
        distance = footprint.distance(start, end)
        if distance <= AGENT_RADIUS and (found is None or distance < found[0]):
            found = distance, body, footprint
    if found is None:
        return None
    _, body, footprint = found
    return Obstacle(_LABELS[body.label], _side(footprint, pose))


def _is_near(body: Body, pose: Pose) -> bool:
    """Return whether a body may be within reach of a step: a cheap bound before the exact distance."""
    box = body.collider
    assert box is not None
    reach = math.hypot(box.half_width, box.half_length) + STEP + AGENT_RADIUS
    return math.hypot(body.position[0] - pose.x, body.position[1] - pose.z) <= reach


def _side(footprint: Footprint, pose: Pose) -> str:
    """Return on which side of a person the nearest point of a footprint is."""
    sin, cos = footprint.sin, footprint.cos
    dx, dy = pose.x - footprint.x, pose.z - footprint.y
    u = min(max(dx * cos - dy * sin, -footprint.half_width), footprint.half_width)
    v = min(max(dx * sin + dy * cos, -footprint.half_length), footprint.half_length)
    right, _ = pose.local(footprint.x + u * cos + v * sin, footprint.y - u * sin + v * cos)
    if abs(right) <= AHEAD:
        return "ahead"
    return "right" if right > 0 else "left"

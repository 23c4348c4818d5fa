"""Observations in words: distances ahead, and what is visible where."""

import math

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Label, Observation
from arramon_client.world import FIELD_OF_VIEW

SECTORS = ("far left", "left", "ahead", "right", "far right")
"""Names of the equal parts of the image's width, from left to right."""

NOT_THINGS = frozenset(("nothing", "road", "pavement", "floor"))
"""Kinds of labels that are ground or sky."""

MAX_THINGS = 24
MIN_SHARE = 0.0005
"""Smallest share of the image's pixels at which a thing is mentioned."""

OPEN = 65.0
"""Distance in metres from which on nothing is in the way."""


def depth_in_words(depth: npt.NDArray[np.float32]) -> str:
    """Return the distances at eye level, in metres, of the nearest surface in each of five directions.

    Args:
        depth: (size, size), as `Observation.depth`.
    """
    middle = depth.shape[0] // 2
    band = depth[max(0, middle - 2) : middle + 1]
    nearest = [_nearest(part) for part in np.array_split(band, len(SECTORS), axis=1)]
    return ", ".join(f"{name}: {distance}" for name, distance in zip(SECTORS, nearest, strict=True))


def things_in_words(observation: Observation, labels: tuple[Label, ...]) -> list[str]:
    """Return what is visible, the nearest first, such as "red mug, 12 degrees right, 3.4 m"; at most MAX_THINGS.

    Args:
        observation: an observation with a segmentation; distances need depth, otherwise the largest comes first.
        labels: the meaning of the segmentation's values.
    """
    segmentation, depth = observation.segmentation, observation.depth
    if segmentation is None:
        return []
    found = []
    for value in np.unique(segmentation):
        label = labels[value] if value < len(labels) else Label("nothing")
        rows, columns = np.nonzero(segmentation == value)
        if label.kind in NOT_THINGS or len(rows) < MIN_SHARE * segmentation.size:
            continue
        distance = None if depth is None else float(np.median(depth[rows, columns]))
        text = f"{_name(label)}, {_direction(float(columns.mean()), segmentation.shape[1])}"
        far = "" if distance is None else f", {distance:.1f} m" if 0 < distance < OPEN else ", far away"
        found.append((-len(rows) if distance is None else distance or math.inf, text + far))
    return [text for _, text in sorted(found)[:MAX_THINGS]]


def _nearest(part: npt.NDArray[np.float32]) -> str:
    hit = part[(part > 0) & (part < OPEN)]
    return f"{hit.min():.1f} m" if hit.size else "open"


def _name(label: Label) -> str:
    return " ".join(part.replace("_", " ") for part in (label.look, label.colour, label.kind) if part)


def _direction(column: float, width: int) -> str:
    """Return the direction of an image column, by the camera's field of view."""
    offset = (2 * column + 1) / width - 1
    angle = round(math.degrees(math.atan(offset * math.tan(math.radians(FIELD_OF_VIEW / 2)))))
    return "ahead" if angle == 0 else f"{abs(angle)} degrees {'right' if angle > 0 else 'left'}"

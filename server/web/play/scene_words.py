"""The visible things of a frame, from its segmentation and depth, for people who do not see it."""

from dataclasses import dataclass

import numpy as np

from arramon_client.world import CELL_SIZE, DEPTH_UNIT, STEP
from arramon_server.sim.cameras import Frame
from arramon_server.sim.labels import LABELS, SegmentationLabel

SIDES = ("left", "ahead", "right")
"""Thirds of the frame, from the left."""

MIN_SHARE = 0.002
"""Minimum share of a third's pixels for a thing to be listed."""

MAX_PER_SIDE = 4
"""Maximum number of things of each third: the nearest."""

SAMPLED = 4
"""Interval of the sampled pixels, in a frame of SAMPLED_SIZE; larger frames are sampled at wider intervals."""

SAMPLED_SIZE = 448

NOT_THINGS = frozenset({"nothing", "road", "pavement", "roof", "floor", "ceiling"})
"""Kinds that are everywhere."""


@dataclass(frozen=True, slots=True)
class VisibleThing:
    """Something in one third of a frame.

    Attributes:
        side: one of SIDES.
        label: its label.
        steps: median distance along the viewing direction, in steps; at least 1.
    """

    side: str
    label: SegmentationLabel
    steps: int


def visible_things(frame: Frame, *, is_room: bool) -> list[VisibleThing]:
    """Return the things that are visible in each third of a frame, the nearest first.

    Things with the same label in one third are one.

    Args:
        frame: a frame with segmentation, and depth as uint16.
        is_room: whether it shows the room, where a step leads to the next cell.
    """
    assert frame.segmentation is not None
    size = frame.segmentation.shape[0]
    stride = max(1, size * SAMPLED // SAMPLED_SIZE)
    labels, depth = frame.segmentation[::stride, ::stride], frame.depth[::stride, ::stride]
    pace = CELL_SIZE if is_room else STEP
    found: list[VisibleThing] = []
    for side, columns in zip(SIDES, np.array_split(np.arange(labels.shape[1]), len(SIDES)), strict=True):
        third, distances = labels[:, columns], depth[:, columns]
        numbers, counts = np.unique(third, return_counts=True)
        here = [
            VisibleThing(side, label, max(1, round(float(np.median(distances[third == number])) * DEPTH_UNIT / pace)))
            for number, count in zip(numbers, counts, strict=True)
            if count >= MIN_SHARE * third.size and (label := LABELS[number]).kind not in NOT_THINGS
        ]
        found += sorted(here, key=lambda thing: thing.steps)[:MAX_PER_SIDE]
    return found

"""Names of landmarks that are unambiguous to a follower on the path.

The ranking is that of the follower (agents/mapping/landmark_memory.py), duplicated as neither may import the other.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from random import Random

from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_lang.meaning import Thing
from arramon_lang.street_words import COUNTED_WITHIN, OFF_AXIS_WEIGHT
from arramon_server.sim.assets.furniture import COLOURS
from arramon_server.sim.geometry import Pose

BEHIND = -1.5
"""Landmarks farther behind the viewer than this are not considered, in units."""

MIN_DISTANCE_RATIO = 1.35
"""Minimum ratio of the perceived distances of any other matching landmark and of the named one."""

ORDINALS = ("first", "second", "third")

MIN_RATIO_WITHOUT_COLOUR = 2.2
"""The same ratio if the name omits the colour although other things of the kind have different colours."""

OMIT_COLOUR = 0.4
"""Probability that an unnecessary colour is omitted."""


OMIT_SHAPE = 0.85
"""Probability that the shape on a banner is omitted if its colour is enough."""

NEVER_BARE = ("awning",)
"""Kinds whose colour is never omitted: facade textures show such things too."""


def unique_name(
    landmark: Landmark, landmarks: Sequence[Landmark], view: Pose, until: int, random: Random
) -> tuple[Thing, bool] | None:
    """Return a name that matches this landmark and no other visible one, or None if there is none.

    Args:
        landmark: seen from the current or an earlier pose.
        landmarks: all landmarks.
        view: position and course of the viewer.
        until: index of the last pose; landmarks that become visible later cannot cause confusion.
        random: draws whether an unnecessary colour is named.

    Returns:
        The name, and whether it would be unique even if all landmarks were visible.
    """
    label = landmark.label
    names = [full_name(landmark)]
    if label.kind in COLOURS and label.kind not in NEVER_BARE and random.random() < OMIT_COLOUR:
        names.insert(0, Thing(label.kind, identity=landmark.identity))
    if label.kind == "banner" and label.look and random.random() < OMIT_SHAPE:
        names.insert(0, Thing(label.kind, label.colour, identity=landmark.identity))
    own = perceived_distance(landmark, view)
    for name in names if own < math.inf else []:
        limit = own * (MIN_DISTANCE_RATIO if name.colour or not label.colour else MIN_RATIO_WITHOUT_COLOUR)
        rivals = [
            m for m in landmarks if m is not landmark and name_matches(name, m) and perceived_distance(m, view) < limit
        ]
        if not any(rival.glimpsed is not None and rival.glimpsed <= until for rival in rivals):
            return name, not rivals
    return None


def full_name(landmark: Landmark) -> Thing:
    """Return the complete name of a landmark: kind, colour and look."""
    return Thing(landmark.label.kind, landmark.label.colour, landmark.label.look, identity=landmark.identity)


def counted_name(
    landmark: Landmark, landmarks: Sequence[Landmark], seen: Sequence[Landmark], view: Pose
) -> Thing | None:
    """Return a name with an ordinal, "the second bench", or None if it is not one of the first three along the walk.

    Args:
        landmark: a landmark ahead.
        landmarks: all landmarks.
        seen: the landmarks seen so far; only these can be counted.
        view: position and course of the walker.
    """
    name = full_name(landmark)
    counted = []
    for other in landmarks:
        right, along = view.local(other.x, other.z)
        if name_matches(name, other) and abs(right) <= COUNTED_WITHIN + 1.0 and along > -1.0:
            counted.append((along, abs(right), other))
    counted.sort(key=lambda each: each[:2])
    alongs = [along for along, _, _ in counted]
    place = next(i for i, (_, _, other) in enumerate([*counted, (0.0, 0.0, landmark)]) if other is landmark)
    if place >= min(len(counted), len(ORDINALS)) or alongs[0] < 1.0:
        return None
    is_clear = all(other in seen and right <= COUNTED_WITHIN for _, right, other in counted[: place + 1])
    is_apart = all(after - before >= 1.5 for before, after in pairwise(alongs[: place + 2]))
    return replace(name, which=ORDINALS[place]) if is_clear and is_apart else None


def name_matches(name: Thing, landmark: Landmark) -> bool:
    """Return whether a name matches a landmark; omitted attributes match anything."""
    label = landmark.label
    return name.kind == label.kind and name.colour in ("", label.colour) and name.look in ("", label.look)


def perceived_distance(landmark: Landmark, view: Pose) -> float:
    """Return a landmark's perceived distance in units: longer off the course, infinite behind the viewer."""
    right, along = view.local(landmark.x, landmark.z)
    if along < BEHIND:
        return math.inf
    off = math.atan2(right, along)
    return math.hypot(right, along) * (1.0 + OFF_AXIS_WEIGHT * off * off)

"""Names for the target of a navigation instruction, and its relation to a nearby landmark."""

import math
from collections.abc import Sequence
from random import Random

from arramon_client.world import COLLECTIBLES
from arramon_dataset.instructions.navigation.groups import groups_centred_on
from arramon_dataset.instructions.navigation.landmark_names import full_name
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.path_tolerances import (
    PLANNED_LAST_VIEWS,
    PLANNED_NEAR,
    PLANNED_RELATION_ANGLE,
    PLANNED_TWIN_GAP,
    PLANNED_ZEBRA_MARGIN,
)
from arramon_dataset.paths import Place, legs_of, offset_seen_from, relation_offset
from arramon_lang.meaning import Thing, Where
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import SegmentationLabel
from arramon_server.sim.rules import Collectible

BUILDING_SHARE = 0.25
"""Probability that a building is considered for locating a target."""

COLLECTIBLE_LIKING = -4.0
"""Bonus for collectibles in the choice of a landmark, as units of distance: people seldom name a second one."""

RELATION_WEIGHTS = {"behind": 300.0, "in_front_of": 6.0, "left_of": 11.0, "right_of": 9.0, "near": 6.0}
"""Relative frequency of each relation where it holds: the rarer it holds, the higher, for people's shares."""

AS_NEAR = 1.5
"""Distance beyond the nearest landmark's within which another may locate the target instead, in units."""

SECOND_SHARE = 0.15
"""Probability of a second landmark ("next to the cone and the dumpster")."""

UNSUITED = ("intersection", "junction", "corner")
"""Kinds of landmarks that never locate a target."""

UNPLACED = 0.88
"""Probability of omitting the location of a target with a unique appearance."""

HUNG = ("awning", "shop_sign")
"""Kinds of landmarks above the street: nothing is said to be behind them."""

GROUP_SHARE = 0.15
"""Probability of a plural name for a group near the target."""

FULL = 0.97
"""Probability of the complete name although fewer words suffice."""


_Nearby = tuple[float, float, float, Landmark]
"""A landmark near the target: its rank, the lowest first, its offset to the right and ahead, and the landmark."""


def describe_target(
    target: Collectible,
    street: Sequence[Collectible],
    landmarks: Sequence[Landmark],
    poses: Sequence[Pose],
    random: Random,
    *,
    must_place: bool = False,
) -> Thing | None:
    """Return a name that matches only the target among the turn's collectibles; None if it is not seen at the end.

    Args:
        target: the object to pick up.
        street: all collectibles of the turn.
        landmarks: landmarks along the path.
        poses: along the path.
        random: draws the words.
        must_place: whether to state its location wherever there is a landmark for it.
    """
    every = landmarks
    landmarks = [landmark for landmark in landmarks if landmark.seen]
    own, at = SegmentationLabel.of(target.type), (target.position.x, target.position.z)
    if not any(
        landmark.label == own
        and math.dist((landmark.x, landmark.z), (target.position.x, target.position.z)) < 0.1
        and landmark.seen[-1] >= len(poses) - 6
        for landmark in landmarks
    ):
        return None
    others = [item.type for item in street if item is not target and item != target]
    kind, colour, pattern = target.type.kind, target.type.colour, target.type.pattern
    short = [(colour, ""), ("", pattern)]
    random.shuffle(short)
    for said_colour, said_pattern in short if random.random() > FULL else []:
        if not any(
            other.kind == kind and said_colour in ("", other.colour) and said_pattern in ("", other.pattern)
            for other in others
        ):
            colour, pattern = said_colour, said_pattern
            break
    identity = next(
        (landmark.identity for landmark in landmarks if landmark.label == own and (landmark.x, landmark.z) == at),
        "target",
    )
    twins = [landmark for landmark in every if landmark.label == own and (landmark.x, landmark.z) != at]
    where = _where(
        target,
        every,
        poses,
        random,
        [landmark for landmark in every if _is_by_any(landmark, twins)] if twins else None,
        0.0 if must_place else UNPLACED,
    )
    return None if twins and not where else Thing(kind, colour, pattern, where=where, identity=identity)


def _is_by_any(landmark: Landmark, twins: Sequence[Landmark]) -> bool:
    """Return whether a landmark is near an object that looks like the target."""
    return any(math.dist((landmark.x, landmark.z), (twin.x, twin.z)) < PLANNED_TWIN_GAP for twin in twins)


def _where(
    target: Collectible,
    every: Sequence[Landmark],
    poses: Sequence[Pose],
    random: Random,
    elsewhere: Sequence[Landmark] | None,
    unplaced: float,
) -> tuple[Where, ...]:
    """Return the target's relation to a landmark near it, as seen when arriving along the path.

    `elsewhere` are the landmarks near objects that look like the target, or None if there are no such objects. If there
    are, no landmark with the same label and no building is used, and the location is always stated; otherwise it is
    omitted with the probability `unplaced`.
    """
    view = poses[max(len(poses) - 6, 0)]
    x, z = target.position.x, target.position.z
    is_alone = elsewhere is None
    unsuited = UNSUITED if random.random() < BUILDING_SHARE and is_alone else (*UNSUITED, "building")
    near: list[_Nearby] = []
    landmarks = [landmark for landmark in every if landmark.seen]
    for landmark in landmarks:
        right, ahead = offset_seen_from((view.x, view.z), (x, z), (landmark.x, landmark.z))
        distance = math.hypot(right, ahead)
        if (
            landmark.label.kind in unsuited
            or landmark.label.look == "grey"
            or distance > PLANNED_NEAR
            or distance < 0.1
            or landmark.seen[-1] < len(poses) - 10
            or landmark.covers_ground(x, z, PLANNED_ZEBRA_MARGIN)
            or any(landmark.label == other.label for other in elsewhere or ())
        ):
            continue
        liking = COLLECTIBLE_LIKING if landmark.label.kind in COLLECTIBLES else 0.0
        near.append((distance + random.random() - liking, right, ahead, landmark))
    if not near or (random.random() < unplaced and is_alone):
        return ()
    nearest = min(near, key=_rank)
    views = [*poses[-PLANNED_LAST_VIEWS:], _at_last_turn(poses)]
    relations: dict[str, _Nearby] = {"near": nearest}
    for item in sorted((item for item in near if item[0] <= nearest[0] + AS_NEAR), key=_rank):
        relation = _relation_of(item, views, (x, z))
        if relation:
            relations.setdefault(relation, item)
    (relation,) = random.choices(list(relations), [RELATION_WEIGHTS[each] for each in relations])
    landmark = relations[relation][3]
    name = full_name(landmark)
    group = next(groups_centred_on(landmark, every, landmarks, len(poses)), None)
    if group is not None and is_alone and random.random() < GROUP_SHARE:
        return (Where("near", (group.name,)),)
    further = [
        item for item in near if item[3] is not landmark and item[3].label.kind not in (landmark.label.kind, "building")
    ]
    if relation == "near" and is_alone and further and random.random() < SECOND_SHARE:
        other = min(further, key=_rank)[3]
        return (Where("near", (name,)), Where("near", (full_name(other),)))
    return (Where(relation, (name,)),)


def _rank(item: _Nearby) -> tuple[float, str]:
    return item[0], item[3].identity


def _relation_of(item: _Nearby, views: Sequence[Pose], place: Place) -> str:
    """Return the direction in which a place is clearly seen from a landmark; "" if there is none.

    People read "behind" as seen from where they stand when they read it: at the last turn, or on arrival. Nothing is
    in a direction from a zebra crossing, nor behind what hangs above the street.
    """
    _, right, ahead, landmark = item
    relation = ""
    if abs(right) > 1.3 * abs(ahead):
        relation = "left_of" if right > 0.0 else "right_of"
    elif abs(ahead) > 1.3 * abs(right):
        relation = "in_front_of" if ahead > 0.0 else "behind"
    is_odd = landmark.label.kind == "zebra_crossing" or (relation == "behind" and landmark.label.kind in HUNG)
    return relation if not is_odd and all(_is_so_from(pose, relation, place, landmark) for pose in views) else ""


def _at_last_turn(poses: Sequence[Pose]) -> Pose:
    """Return the pose where the last straight part of a path begins."""
    legs = legs_of(tuple(dict.fromkeys((pose.x, pose.z) for pose in poses)))
    return Pose(*legs[-1].start, legs[-1].heading) if legs else poses[-1]


def _is_so_from(view: Pose, relation: str, place: Place, landmark: Landmark) -> bool:
    """Return whether a place is clearly in a relation to a landmark, as seen from a pose."""
    offset = relation_offset(relation, *offset_seen_from((view.x, view.z), place, (landmark.x, landmark.z)))
    if offset is None:
        return True
    along, across = offset
    return along > 0.0 and abs(across) <= math.tan(math.radians(PLANNED_RELATION_ANGLE)) * along

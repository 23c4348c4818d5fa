"""Input features of the policy: the parsed instruction, and the agent's map relative to its pose."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.ground_map import CELL, SIDE, GroundMap
from arramon_agents.mapping.probabilistic_landmark_memory import LandmarkBelief
from arramon_agents.perception.eyes.vocabulary import COLOURED, COLOURS, KINDS, LOOK_GROUPS, LOOKS, look_slices
from arramon_agents.reading.reader.slots import EMPTY, SLOTS, Row
from arramon_client.world import COLLECTIBLES, FURNITURE
from arramon_lang.meaning import OTHER_SIDE

ROWS, THINGS, TRACE = 16, 24, 12
"""Maximum numbers of instruction rows, landmarks and past positions in the input."""

DIRECTIONS = 24
RADII = np.arange(0.75, 12.01, 0.75)
"""Distances at which the ground is sampled in each direction, in units."""

GROUND_CHANNELS = 3
"""Channels of the ground map: seen free; blocked for the agent; wall."""

THING_VALUES, TRACE_VALUES, STATE_VALUES = 13, 6, 6

TRACE_STRIDE = 2
"""Stride of past positions, from the latest back; the first position of the walk is always included."""

REFERENCE_FAR, MIN_MATCH = 10.0, 0.4
"""Distance at which a landmark counts as far from the target's reference object, in units; minimum match of a landmark
with the reference object."""

MAX_LANDMARK_DISTANCE = 30.0
"""Distance beyond which landmarks are ignored, in units."""

Floats = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]


class PolicyInput(NamedTuple):
    """Input of one decision. Positions (right, ahead) are relative to the agent's pose, in units.

    Attributes:
        rows: instruction rows, (ROWS, slots) int64: value ids, see `without_names`; padded with 0.
        ground: ground map in polar coordinates, (DIRECTIONS, radii, GROUND_CHANNELS) uint8, 0 or 1; directions
            clockwise from ahead.
        things: landmarks, (THINGS, THING_VALUES) float32. In order: 1 for a landmark, 0 for padding; right, ahead;
            right, ahead and age in moves from the past pose that was nearest to it; probabilities of collectible,
            building, crossing, other furniture; match with the target; best match with any named object; distance from
            the target's reference object, 1 at REFERENCE_FAR and beyond.
        match: (2, ROWS, THINGS) float32, match of each landmark with the first and second object that each row names.
        trace: past positions, (TRACE, TRACE_VALUES) float32: 1, or 0 for padding; right, ahead; sine and cosine of the
            relative heading; age in moves. The last one is the start of the walk.
        state: (STATE_VALUES,) float32: moves / 100; steps left / 100; turn - 1; moves / 10, at most 1; best match of a
            landmark with the target; constant 1.
    """

    rows: npt.NDArray[np.int64]
    ground: Bytes
    things: Floats
    match: Floats
    trace: Floats
    state: Floats


@dataclass(frozen=True)
class AgentKnowledge:
    """The agent's knowledge at a decision.

    Attributes:
        ground: map of the ground.
        trace: poses (x, z, heading in radians) of this walk: the first one, and one after each move.
        beliefs: landmarks with their attribute probabilities.
        steps_left: steps left in the phase.
        turn: 1 or 2.
    """

    ground: GroundMap
    trace: Sequence[tuple[float, float, float]]
    beliefs: Sequence[LandmarkBelief]
    steps_left: int
    turn: int

    @property
    def pose(self) -> tuple[float, float, float]:
        """The agent's (x, z, heading in radians)."""
        return self.trace[-1]


def _slot(name: str) -> int:
    return list(SLOTS).index(name)


_TYPE = _slot("type")
_NAME_SLOTS = [[_slot(f"{name}{number}") for name in ("kind", "colour", "look")] for number in (1, 2)]
_TARGET = SLOTS["type"].index("target")

_LOOK_PLACES = look_slices()
_PATTERN = _LOOK_PLACES["pattern"]
_GROUP_OF = {kind: group for group in LOOK_GROUPS for kind in group.kinds}
_COLLECTIBLE = [KINDS.index(kind) for kind in COLLECTIBLES]
_OF_SEVERAL_COLOURS = (*COLLECTIBLES, *COLOURED, "banner")
_BUILDING, _CROSSING = KINDS.index("building"), KINDS.index("zebra_crossing")


_ALIKE = {
    **dict.fromkeys(COLLECTIBLES, COLLECTIBLES[0]),
    **dict.fromkeys((kind for kind in FURNITURE if kind != "zebra_crossing"), FURNITURE[0]),
}
_WITHOUT_NAMES = {
    _slot(name): np.array(
        [SLOTS[name].index(_ALIKE.get(value, value) if "kind" in name else "") for value in SLOTS[name]]
    )
    for names in (("kind1", "colour1", "look1"), ("kind2", "colour2", "look2"))
    for name in names
}


def without_names(rows: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Replace the names in rows: one kind for all furniture, one for all collectibles, no colours or looks.

    The network would memorise where each named thing is in the few training sections. It gets the match of landmarks
    with the names as a separate input instead (`match_of`).
    """
    rows = rows.copy()
    for slot, alike in _WITHOUT_NAMES.items():
        rows[..., slot] = alike[rows[..., slot]]
    return rows


class NamedAttributes(NamedTuple):
    """Attributes by which an instruction names a thing, as indices of kinds, colour and look; None if not named."""

    kinds: tuple[int, ...]
    colour: int | None
    look: int | None

    @property
    def has_colour(self) -> bool:
        """Whether things of these kinds come in several colours, so that a named colour distinguishes them."""
        return any(KINDS[kind] in _OF_SEVERAL_COLOURS for kind in self.kinds)

    def is_facade(self, look: str) -> bool:
        """Return whether a building with this facade matches."""
        return self.kinds == (_BUILDING,) and (self.look is None or LOOKS[self.look] == ("facade", look))


def named_attributes(row: Row, number: int) -> NamedAttributes | None:
    """Return the attributes of the first or second thing that a row names; None if it cannot be a landmark.

    Args:
        row: a row of an instruction.
        number: 0 for the first thing, 1 for the second.
    """
    kind, colour, look = (SLOTS[list(SLOTS)[slot]][row[slot]] for slot in _NAME_SLOTS[number])
    if not (kind or colour or look) or (kind and kind not in KINDS):
        return None
    kinds = (KINDS.index(kind),) if kind else tuple(_COLLECTIBLE)
    group = _GROUP_OF.get(kind or COLLECTIBLES[0])
    place = None
    if look and group is not None and look in group.looks:
        place = _LOOK_PLACES[group.name].start + group.looks.index(look)
    return NamedAttributes(kinds, COLOURS.index(colour) if colour else None, place)


def match_of(rows: Sequence[Row], beliefs: Sequence[LandmarkBelief]) -> Floats:
    """Return the probability that each landmark matches the things that each row names, (2, rows, landmarks)."""
    found = np.zeros((2, len(rows), len(beliefs)), np.float32)
    if not beliefs:
        return found
    kinds = np.stack([belief.kinds for belief in beliefs])
    colours = np.stack([belief.colours for belief in beliefs])
    looks = np.stack([belief.looks for belief in beliefs])
    for number in range(2):
        for place, row in enumerate(rows):
            thing = named_attributes(row, number)
            if thing is None:
                continue
            match = kinds[:, list(thing.kinds)].sum(1)
            if thing.colour is not None and thing.has_colour:
                match = match * colours[:, thing.colour]
            if thing.look is not None:
                match = match * looks[:, thing.look]
            found[number, place] = match
    return found


def policy_input(rows: Sequence[Row], knowledge: AgentKnowledge) -> tuple[PolicyInput, list[LandmarkBelief]]:
    """Return the input of the policy, and the landmarks in it, in order.

    Args:
        rows: rows of the instruction; only the first ROWS are used.
        knowledge: the agent's knowledge.
    """
    rows = list(rows)[:ROWS]
    match = match_of(rows, knowledge.beliefs)
    is_target = np.array([row[_TYPE] == _TARGET for row in rows], bool)
    chosen = _choose(match, knowledge)
    beliefs = [knowledge.beliefs[place] for place in chosen]
    match = match[:, :, chosen]
    is_place = np.cumsum(is_target).astype(bool) & ~is_target
    to_target = match[0][is_target].max(0, initial=0.0) if len(chosen) else np.zeros(0, np.float32)
    best = match.max((0, 1), initial=0.0) if len(chosen) else np.zeros(0, np.float32)
    padded = np.zeros((2, ROWS, THINGS), np.float32)
    padded[:, : len(rows), : len(chosen)] = match
    things = np.zeros((THINGS, THING_VALUES), np.float32)
    if beliefs:
        things[: len(beliefs)] = _things(
            beliefs, knowledge, to_target, best, match[:, is_place].max((0, 1), initial=0.0)
        )
    moves = len(knowledge.trace) - 1
    state = np.array(
        [
            moves / 100.0,
            knowledge.steps_left / 100.0,
            knowledge.turn - 1.0,
            min(moves / 10.0, 1.0),
            float(to_target.max(initial=0.0)),
            1.0,
        ],
        np.float32,
    )
    numbers = without_names(np.array([*rows, *[EMPTY] * (ROWS - len(rows))], np.int64))
    return PolicyInput(numbers, _ground(knowledge), things, padded, _trace(knowledge), state), beliefs


def _choose(match: Floats, knowledge: AgentKnowledge) -> list[int]:
    """Select the landmarks for the input, by index: matches with named things first, then the nearest."""
    x, z, _ = knowledge.pose
    best = match.max((0, 1), initial=0.0)
    ranked = []
    for place, belief in enumerate(knowledge.beliefs):
        distance = math.hypot(belief.mark.x - x, belief.mark.z - z)
        if distance < MAX_LANDMARK_DISTANCE:
            ranked.append((distance - 30.0 * float(best[place]), place))
    return [place for _, place in sorted(ranked)[:THINGS]]


def _things(
    beliefs: Sequence[LandmarkBelief],
    knowledge: AgentKnowledge,
    to_target: Floats,
    best: Floats,
    reference_match: Floats,
) -> Floats:
    places = np.array([(belief.mark.x, belief.mark.z) for belief in beliefs])
    right, ahead = relative_to(places, knowledge.pose)
    trace = np.array(knowledge.trace)
    away = np.hypot(places[:, 0, None] - trace[:, 0], places[:, 1, None] - trace[:, 1])
    # Among equally near positions take the last: the agent may have turned there.
    nearest = away.shape[1] - 1 - away[:, ::-1].argmin(1)
    then = np.array(
        [relative_to(places[number : number + 1], knowledge.trace[at]) for number, at in enumerate(nearest)]
    )
    kinds = np.stack([belief.kinds for belief in beliefs])
    collectible, building, crossing = kinds[:, _COLLECTIBLE].sum(1), kinds[:, _BUILDING], kinds[:, _CROSSING]
    values = [
        np.ones(len(beliefs)),
        right,
        ahead,
        then[:, 0, 0],
        then[:, 1, 0],
        len(trace) - 1 - nearest,
        collectible,
        building,
        crossing,
        1.0 - collectible - building - crossing,
        to_target,
        best,
        _distance_to(places, places[reference_match > MIN_MATCH]),
    ]
    return np.stack(values, 1).astype(np.float32)


def _distance_to(places: npt.NDArray[np.float64], others: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return each place's distance from the nearest of the others, in REFERENCE_FAR units, at most 1."""
    if not len(others):
        return np.ones(len(places))
    away = np.hypot(places[:, 0, None] - others[:, 0], places[:, 1, None] - others[:, 1])
    nearest: npt.NDArray[np.float64] = np.minimum(away.min(1) / REFERENCE_FAR, 1.0)
    return nearest


def relative_to(
    places: npt.NDArray[np.float64], pose: tuple[float, float, float]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the positions of places, (n, 2), relative to a pose: right and ahead, (n,) each."""
    sin, cos = math.sin(pose[2]), math.cos(pose[2])
    dx, dz = places[:, 0] - pose[0], places[:, 1] - pose[1]
    return dx * cos - dz * sin, dx * sin + dz * cos


def _trace(knowledge: AgentKnowledge) -> Floats:
    last = len(knowledge.trace) - 1
    numbers = [*range(last - TRACE_STRIDE, 0, -TRACE_STRIDE)][: TRACE - 1]
    found = np.zeros((TRACE, TRACE_VALUES), np.float32)
    for place, number in [*enumerate(numbers), (TRACE - 1, 0)]:
        x, z, heading = knowledge.trace[number]
        right, ahead = relative_to(np.array([(x, z)]), knowledge.pose)
        turned = heading - knowledge.pose[2]
        found[place] = 1.0, right[0], ahead[0], math.sin(turned), math.cos(turned), last - number
    return found


_ANGLES = np.arange(DIRECTIONS) * (2.0 * math.pi / DIRECTIONS)
_BETWEEN = np.array([-1.0, 0.0, 1.0]) * (2.0 * math.pi / DIRECTIONS / 3.0)
_PARTS = 3
_FINE = np.arange(1, len(RADII) * _PARTS + 1) * (float(RADII[0]) / _PARTS)
"""Distances at which the map is sampled: three for each of RADII."""


def _ground(knowledge: AgentKnowledge) -> Bytes:
    """Return the ground map in polar coordinates, max-pooled, (DIRECTIONS, radii, GROUND_CHANNELS)."""
    x, z, heading = knowledge.pose
    angles = (heading + _ANGLES)[:, None, None] + _BETWEEN[None, :, None]
    rows = ((x + np.sin(angles) * _FINE) / CELL + SIDE / 2).astype(np.int64).clip(0, SIDE - 1)
    columns = ((z + np.cos(angles) * _FINE) / CELL + SIDE / 2).astype(np.int64).clip(0, SIDE - 1)
    cells = (rows * SIDE + columns).reshape(DIRECTIONS, len(_BETWEEN), len(RADII), _PARTS)
    layers = knowledge.ground.free, knowledge.ground.blocked, knowledge.ground.wall
    free, blocked, wall = (np.frombuffer(layer, np.uint8)[cells] for layer in layers)
    # Free ground has gaps between the rays of a scan, so it is pooled across; blocked cells are not.
    return np.stack([free.max((1, 3)), blocked[:, 1].max(2), wall.max((1, 3))], -1)


_MIRRORED_SLOTS = {
    _slot(name): np.array([SLOTS[name].index(OTHER_SIDE.get(value, value)) for value in SLOTS[name]])
    for name in ("direction", "side", "relation")
}


def mirror(sample: PolicyInput) -> PolicyInput:
    """Return the input for the mirrored world, with left and right exchanged in the instruction too.

    Args:
        sample: one input, or a batch with a leading axis.
    """
    rows = sample.rows.copy()
    for slot, exchanged in _MIRRORED_SLOTS.items():
        rows[..., slot] = exchanged[rows[..., slot]]
    things, trace = sample.things.copy(), sample.trace.copy()
    things[..., [1, 3]] *= -1.0
    trace[..., [1, 3]] *= -1.0
    ground = sample.ground[..., -np.arange(DIRECTIONS) % DIRECTIONS, :, :]
    return sample._replace(rows=rows, ground=ground, things=things, trace=trace)

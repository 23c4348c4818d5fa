"""Input of the policy: the steps read, and the ground and landmarks remembered, relative to the agent's pose."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.ground_map import CELL, SIDE, GroundMap
from arramon_agents.mapping.landmark_beliefs import Belief
from arramon_agents.perception.eyes.vocabulary import COLOURED, COLOURS, KINDS, LOOK_GROUPS, LOOKS, look_slices
from arramon_agents.reading.reader.slots import EMPTY, SLOTS, Row
from arramon_client.world import COLLECTIBLES, FURNITURE
from arramon_lang.meaning import OTHER_SIDE

ROWS, THINGS, TRACE = 16, 24, 12
"""Largest numbers of instruction rows, landmarks and past positions in the input."""

DIRECTIONS = 24
RADII = np.arange(0.75, 12.01, 0.75)
"""Distances at which the ground is sampled in each direction, in units."""

GROUND_CHANNELS = 3
"""Channels of the ground at a distance: seen free; blocked for the agent; wall."""

THING_VALUES, TRACE_VALUES, STATE_VALUES = 13, 6, 6

TRACE_STRIDE = 2
"""Stride of the past positions in the input, the latest first; the walk's first position is always included."""

REFERENCE_FAR, MIN_MATCH = 10.0, 0.4
"""Distance from the target's reference thing that counts as far, in units; least match of a landmark to be it."""

FAR = 30.0
"""Distance beyond which landmarks are left out, in units."""

Floats = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]


class PolicyInput(NamedTuple):
    """Input of one decision. Right and ahead are relative to the agent's pose, in units.

    Attributes:
        rows: (ROWS, slots) int64, value ids, `without_names`; all 0 after the instruction's end.
        ground: (DIRECTIONS, radii, GROUND_CHANNELS) uint8, 0 or 1; directions clockwise from ahead.
        things: (THINGS, THING_VALUES) float32: whether there is one; right, ahead; then of where the agent was nearest
            to it: right and ahead of it as it walked there, moves since; whether it is a collectible, a building, a
            crossing, or else furniture; how well it matches the target, and how well the best of any named thing; how
            far it is from what tells the target's place, from 0 to 1 for REFERENCE_FAR units and more.
        match: (2, ROWS, THINGS) float32, how well each matches the first and the second thing that a row names.
        trace: (TRACE, TRACE_VALUES) float32: whether there is one; right, ahead, sine and cosine of the heading there,
            moves since. The last is where the walk began.
        state: (STATE_VALUES,) float32: moves so far, steps left, both in hundreds; turn 2 or 1; moves in tens, at most
            1; whether a collectible was seen that matches the target; 1.
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
        ground: its map.
        trace: poses (x, z, heading in radians) after each move of this walk, from the first pose on; at least one.
        beliefs: the landmarks.
        steps_left: steps left in the phase.
        turn: 1 or 2.
    """

    ground: GroundMap
    trace: Sequence[tuple[float, float, float]]
    beliefs: Sequence[Belief]
    steps_left: int
    turn: int

    @property
    def pose(self) -> tuple[float, float, float]:
        """The agent's (x, z, heading in radians)."""
        return self.trace[-1]


def _slot(name: str) -> int:
    return list(SLOTS).index(name)


_TYPE = _slot("type")
_SAID = [[_slot(f"{name}{number}") for name in ("kind", "colour", "look")] for number in (1, 2)]
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
    """Return rows with one name for all furniture, one for all collectibles, and no colours or looks.

    How well landmarks match the names is a separate input (`match_of`). Names would be memorised, as each has its
    places in the few training sections.
    """
    rows = rows.copy()
    for slot, alike in _WITHOUT_NAMES.items():
        rows[..., slot] = alike[rows[..., slot]]
    return rows


class NamedAttributes(NamedTuple):
    """The named attributes of a thing, as indices of kinds, colour and look; empty for none."""

    kinds: tuple[int, ...]
    colour: int | None
    look: int | None

    @property
    def has_colour(self) -> bool:
        """Whether things of these kinds come in several colours; of others a colour ("the green tree") says nothing."""
        return any(KINDS[kind] in _OF_SEVERAL_COLOURS for kind in self.kinds)

    def is_facade(self, look: str) -> bool:
        """Return whether this names a building with this facade."""
        return self.kinds == (_BUILDING,) and (self.look is None or LOOKS[self.look] == ("facade", look))


def named_attributes(row: Row, number: int) -> NamedAttributes | None:
    """Return the first or second thing that a row names; None if it cannot be a landmark.

    Args:
        row: of an instruction.
        number: 0 for the first, 1 for the second.
    """
    kind, colour, look = (SLOTS[list(SLOTS)[slot]][row[slot]] for slot in _SAID[number])
    if not (kind or colour or look) or (kind and kind not in KINDS):
        return None
    kinds = (KINDS.index(kind),) if kind else tuple(_COLLECTIBLE)
    group = _GROUP_OF.get(kind or COLLECTIBLES[0])
    place = None
    if look and group is not None and look in group.looks:
        place = _LOOK_PLACES[group.name].start + group.looks.index(look)
    return NamedAttributes(kinds, COLOURS.index(colour) if colour else None, place)


def match_of(rows: Sequence[Row], beliefs: Sequence[Belief]) -> Floats:
    """Return the probabilities that landmarks match the things that rows name, (2, rows, landmarks)."""
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


def policy_input(rows: Sequence[Row], moment: AgentKnowledge) -> tuple[PolicyInput, list[Belief]]:
    """Return the input of the policy, and its landmarks in order.

    Args:
        rows: of the instruction; those after the first ROWS are left out.
        moment: the agent's knowledge.
    """
    rows = list(rows)[:ROWS]
    match = match_of(rows, moment.beliefs)
    is_target = np.array([row[_TYPE] == _TARGET for row in rows], bool)
    chosen = _choose(match, moment)
    beliefs = [moment.beliefs[place] for place in chosen]
    match = match[:, :, chosen]
    is_place = np.cumsum(is_target).astype(bool) & ~is_target
    to_target = match[0][is_target].max(0, initial=0.0) if len(chosen) else np.zeros(0, np.float32)
    best = match.max((0, 1), initial=0.0) if len(chosen) else np.zeros(0, np.float32)
    padded = np.zeros((2, ROWS, THINGS), np.float32)
    padded[:, : len(rows), : len(chosen)] = match
    things = np.zeros((THINGS, THING_VALUES), np.float32)
    if beliefs:
        things[: len(beliefs)] = _things(beliefs, moment, to_target, best, match[:, is_place].max((0, 1), initial=0.0))
    moves = len(moment.trace) - 1
    state = np.array(
        [
            moves / 100.0,
            moment.steps_left / 100.0,
            moment.turn - 1.0,
            min(moves / 10.0, 1.0),
            float(to_target.max(initial=0.0)),
            1.0,
        ],
        np.float32,
    )
    numbers = without_names(np.array([*rows, *[EMPTY] * (ROWS - len(rows))], np.int64))
    return PolicyInput(numbers, _ground(moment), things, padded, _trace(moment), state), beliefs


def _choose(match: Floats, moment: AgentKnowledge) -> list[int]:
    """Return the indices of the landmarks for the input: those that match named things first, then the nearest."""
    x, z, _ = moment.pose
    best = match.max((0, 1), initial=0.0)
    ranked = []
    for place, belief in enumerate(moment.beliefs):
        distance = math.hypot(belief.mark.x - x, belief.mark.z - z)
        if distance < FAR:
            ranked.append((distance - 30.0 * float(best[place]), place))
    return [place for _, place in sorted(ranked)[:THINGS]]


def _things(
    beliefs: Sequence[Belief], moment: AgentKnowledge, to_target: Floats, best: Floats, tells_place: Floats
) -> Floats:
    places = np.array([(belief.mark.x, belief.mark.z) for belief in beliefs])
    right, ahead = relative_to(places, moment.pose)
    trace = np.array(moment.trace)
    away = np.hypot(places[:, 0, None] - trace[:, 0], places[:, 1, None] - trace[:, 1])
    # Of equally near positions the last counts: the agent may have turned there.
    nearest = away.shape[1] - 1 - away[:, ::-1].argmin(1)
    then = np.array([relative_to(places[number : number + 1], moment.trace[at]) for number, at in enumerate(nearest)])
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
        _distance_to(places, places[tells_place > MIN_MATCH]),
    ]
    return np.stack(values, 1).astype(np.float32)


def _distance_to(places: npt.NDArray[np.float64], others: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the distance of each place from the nearest of the others, from 0 to 1 for REFERENCE_FAR units and more."""
    if not len(others):
        return np.ones(len(places))
    away = np.hypot(places[:, 0, None] - others[:, 0], places[:, 1, None] - others[:, 1])
    nearest: npt.NDArray[np.float64] = np.minimum(away.min(1) / REFERENCE_FAR, 1.0)
    return nearest


def relative_to(
    places: npt.NDArray[np.float64], pose: tuple[float, float, float]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return places, (n, 2), relative to a pose: right and ahead."""
    sin, cos = math.sin(pose[2]), math.cos(pose[2])
    dx, dz = places[:, 0] - pose[0], places[:, 1] - pose[1]
    return dx * cos - dz * sin, dx * sin + dz * cos


def _trace(moment: AgentKnowledge) -> Floats:
    last = len(moment.trace) - 1
    numbers = [*range(last - TRACE_STRIDE, 0, -TRACE_STRIDE)][: TRACE - 1]
    found = np.zeros((TRACE, TRACE_VALUES), np.float32)
    for place, number in [*enumerate(numbers), (TRACE - 1, 0)]:
        x, z, heading = moment.trace[number]
        right, ahead = relative_to(np.array([(x, z)]), moment.pose)
        turned = heading - moment.pose[2]
        found[place] = 1.0, right[0], ahead[0], math.sin(turned), math.cos(turned), last - number
    return found


_ANGLES = np.arange(DIRECTIONS) * (2.0 * math.pi / DIRECTIONS)
_BETWEEN = np.array([-1.0, 0.0, 1.0]) * (2.0 * math.pi / DIRECTIONS / 3.0)
_PARTS = 3
_FINE = np.arange(1, len(RADII) * _PARTS + 1) * (float(RADII[0]) / _PARTS)
"""Distances at which the map is read: three for each of RADII, up to it."""


def _ground(moment: AgentKnowledge) -> Bytes:
    """Return the ground in each direction, (DIRECTIONS, radii, GROUND_CHANNELS), each with what is around it."""
    x, z, heading = moment.pose
    angles = (heading + _ANGLES)[:, None, None] + _BETWEEN[None, :, None]
    rows = ((x + np.sin(angles) * _FINE) / CELL + SIDE / 2).astype(np.int64).clip(0, SIDE - 1)
    columns = ((z + np.cos(angles) * _FINE) / CELL + SIDE / 2).astype(np.int64).clip(0, SIDE - 1)
    cells = (rows * SIDE + columns).reshape(DIRECTIONS, len(_BETWEEN), len(RADII), _PARTS)
    layers = moment.ground.free, moment.ground.blocked, moment.ground.wall
    free, blocked, wall = (np.frombuffer(layer, np.uint8)[cells] for layer in layers)
    # Free ground is seen with gaps, between the rays; a place is blocked by what is in its middle alone.
    return np.stack([free.max((1, 3)), blocked[:, 1].max(2), wall.max((1, 3))], -1)


_MIRRORED_SLOTS = {
    _slot(name): np.array([SLOTS[name].index(OTHER_SIDE.get(value, value)) for value in SLOTS[name]])
    for name in ("direction", "side", "relation")
}


def mirror(sample: PolicyInput) -> PolicyInput:
    """Return the input in a mirrored world, with left and right exchanged in the instruction.

    Args:
        sample: one, or several with one more axis in front.
    """
    rows = sample.rows.copy()
    for slot, exchanged in _MIRRORED_SLOTS.items():
        rows[..., slot] = exchanged[rows[..., slot]]
    things, trace = sample.things.copy(), sample.trace.copy()
    things[..., [1, 3]] *= -1.0
    trace[..., [1, 3]] *= -1.0
    ground = sample.ground[..., -np.arange(DIRECTIONS) % DIRECTIONS, :, :]
    return sample._replace(rows=rows, ground=ground, things=things, trace=trace)

"""Random sidesteps that make planned paths look like walks of people.

On straight parts of a path the walker sometimes turns by 30 degrees, steps to one side, turns back, and continues
beside the line, within `MAX_OFFSET` of it. The course, its corners and its end stay the same.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

import numpy as np
import numpy.typing as npt

from arramon_client.world import HEADINGS, STEP, TURN, Action
from arramon_dataset.generation.clearance_raster import CELL, ClearanceRaster, Numbers
from arramon_dataset.generation.path_planner import REACH_FROM, REACH_OFFSET, REACH_TO, SIGHT_CLEARANCE, STEP_CLEARANCE
from arramon_server.sim.geometry import Pose

SIDESTEP_CHANCE, RETURN_CHANCE = 0.45, 0.5
"""Probabilities of a sidestep off the line and of one back to it, before each forward move where one fits."""

LENGTHS = (1, 2), (40, 60)
"""Forward moves of a sidestep off the line, and their percentages."""

MAX_OFFSET = 1.0
"""Maximum distance from the straight line, in units."""

MIN_STRAIGHT_BEFORE = 3
"""Minimum number of forward moves between a turn of the path or another sidestep and a sidestep: with fewer, two turns
in succession would be a bend that the instruction has to mention."""

MIN_STRAIGHT_AFTER = 2.0
"""Minimum length of the straight part that remains after a sidestep, in units."""

SIDESTEP_CLEARANCE = 700
"""Minimum clearance at the end of each move of a sidestep, in thousandths of a unit."""

TRIES, PART_TRIES = 3, 6
"""Maximum number of attempts for a whole walk, after which the path stays as planned, and for each straight part."""

SAMPLES, SIGHT_SAMPLES = 8, 16
"""Segments of a step and of the line of sight to the target; clearance is sampled at their ends, as in `search`."""

Step = tuple[float, float]


@dataclass(frozen=True, slots=True)
class _StraightPart:
    """A straight part of a path: the turns before it, the index of its heading, and where it ends."""

    turns: tuple[Action, ...]
    heading: int
    end: tuple[float, float]


@dataclass(frozen=True, slots=True)
class _PartialWalk:
    """The beginning of a walk: its actions, and the position after them."""

    actions: tuple[Action, ...]
    x: float
    z: float


def with_sidesteps(
    ground: ClearanceRaster, start: Pose, actions: Sequence[Action], target: tuple[float, float], random: Random
) -> list[Action]:
    """Return a planned path's actions with random sidesteps, or unchanged if no such walk is found.

    Args:
        ground: clearance raster of the section.
        start: pose before the first action.
        actions: a path to the target with few turns, from `path_planner.PathPlanner.actions`.
        target: (x, z), in units.
        random: draws the sidesteps.
    """
    walker = _SidestepSampler(ground, start, target, random)
    parts, last = walker.parts(actions)
    for _ in range(TRIES):
        walk: _PartialWalk | None = _PartialWalk((), start.x, start.z)
        for number, part in enumerate(parts):
            if walk is not None:
                walk = walker.part(walk, part, last if number == len(parts) - 1 else None)
        if walk is not None:
            return [*walk.actions, *last]
    return list(actions)


class _SidestepSampler:
    """Samples walks along one planned path."""

    def __init__(self, ground: ClearanceRaster, start: Pose, target: tuple[float, float], random: Random) -> None:
        self._ground, self._start, self._target, self._random = ground, start, target, random
        angles = np.radians(start.heading + TURN * np.arange(HEADINGS))
        steps = np.round(STEP * np.stack([np.sin(angles), np.cos(angles)], axis=1), 9)
        self._steps: list[Step] = [(x, z) for x, z in steps.tolist()]

    def parts(self, actions: Sequence[Action]) -> tuple[list[_StraightPart], tuple[Action, ...]]:
        """Return the straight parts of a path, and the turns at its end."""
        parts: list[_StraightPart] = []
        turns: list[Action] = []
        x, z, heading = self._start.x, self._start.z, 0
        for number, action in enumerate(actions):
            if action is not Action.FORWARD:
                turns.append(action)
                heading = _turned(heading, action)
                continue
            x, z = x + self._steps[heading][0], z + self._steps[heading][1]
            if number + 1 == len(actions) or actions[number + 1] is not Action.FORWARD:
                parts.append(_StraightPart(tuple(turns), heading, (x, z)))
                turns = []
        return parts, tuple(turns)

    def part(self, walk: _PartialWalk, part: _StraightPart, last: Sequence[Action] | None) -> _PartialWalk | None:
        """Return the walk extended along the next straight part, or None if no free continuation is found.

        Args:
            walk: the walk so far.
            part: the next straight part of the path.
            last: the turns after the part, if it is the last one: after them the target must be within reach and in
                view; None if more parts follow.
        """
        facing = part.heading
        for action in last or ():
            facing = _turned(facing, action)
        for _ in range(PART_TRIES):
            for more in (0, 1) if last is not None else (0,):
                drawn = self._draw(walk, part, more)
                if drawn is not None and (last is None or self._is_at(drawn, facing)):
                    return drawn
        return None

    def _draw(self, walk: _PartialWalk, part: _StraightPart, more: int) -> _PartialWalk | None:
        """Return the walk extended with random sidesteps to the end of a part; None if it lacks clearance.

        Args:
            walk: the walk so far.
            part: the next straight part of the path.
            more: number of forward moves beyond its end.
        """
        along_x, along_z = self._steps[part.heading]
        actions, places = [*walk.actions, *part.turns], [(walk.x, walk.z)]
        aside: list[int] = []
        straight = 0
        while True:
            x, z = places[-1]
            left = (part.end[0] - x) * along_x + (part.end[1] - z) * along_z + more * STEP
            if left <= STEP / 2:
                break
            right = (x - part.end[0]) * along_z - (z - part.end[1]) * along_x
            length, side = self._sidestep(right) if straight >= MIN_STRAIGHT_BEFORE else (0, 1)
            fits = left - length * STEP * math.sqrt(0.75) >= MIN_STRAIGHT_AFTER
            if not length or not fits or abs(right + side * length * STEP / 2) > MAX_OFFSET:
                places.append((x + along_x, z + along_z))
                actions.append(Action.FORWARD)
                straight += 1
                continue
            off, back = (Action.RIGHT, Action.LEFT) if side > 0 else (Action.LEFT, Action.RIGHT)
            off_x, off_z = self._steps[_turned(part.heading, off)]
            actions += [off, *[Action.FORWARD] * length, back]
            aside += range(len(places), len(places) + length)
            places += [(x + off_x * n, z + off_z * n) for n in range(1, length + 1)]
            straight = 0
        return _PartialWalk(tuple(actions), *places[-1]) if self._is_free(places, aside) else None

    def _sidestep(self, right: float) -> tuple[int, int]:
        """Return the number of a sidestep's forward moves, 0 for none, and its side: 1 for right, -1 for left.

        Args:
            right: distance of the walker to the right of the line, in units.
        """
        is_off = abs(right) >= STEP / 2 - 0.1
        if self._random.random() >= (RETURN_CHANCE if is_off else SIDESTEP_CHANCE):
            return 0, 1
        if is_off:
            return max(round(abs(right) / (STEP / 2)), 1), -1 if right > 0.0 else 1
        return self._random.choices(*LENGTHS)[0], self._random.choice((-1, 1))

    def _is_free(self, places: Sequence[tuple[float, float]], aside: Sequence[int]) -> bool:
        """Return whether all moves keep the minimum clearance, sampled as in `search`."""
        if len(places) == 1:
            return True
        at = np.array(places)
        shares = np.arange(1, SAMPLES + 1)[:, None, None] / SAMPLES
        clear = self._clearance(at[:-1] + np.diff(at, axis=0) * shares)
        return bool(
            (clear >= STEP_CLEARANCE).all()
            and (clear[-1, [number - 1 for number in aside]] >= SIDESTEP_CLEARANCE).all()
        )

    def _is_at(self, walk: _PartialWalk, facing: int) -> bool:
        """Return whether the target is within reach and in view at the end of a walk."""
        to_x, to_z = self._target[0] - walk.x, self._target[1] - walk.z
        sin, cos = self._steps[facing]
        ahead, aside = to_x * sin + to_z * cos, abs(to_x * cos - to_z * sin)
        if ahead < REACH_FROM or ahead > REACH_TO or aside > REACH_OFFSET:
            return False
        shares = np.arange(1, SIGHT_SAMPLES + 1)[:, None] / SIGHT_SAMPLES
        places = np.array((walk.x, walk.z)) + np.array((to_x, to_z)) * shares
        return bool((self._clearance(places) >= SIGHT_CLEARANCE).all())

    def _clearance(self, places: npt.NDArray[np.float64]) -> Numbers:
        """Return the clearance at places, (..., 2), in thousandths of a unit; -1 outside the raster."""
        columns, rows = self._ground.clearance.shape
        cells = np.floor((places - (self._ground.left, self._ground.bottom)) / CELL).astype(np.int64)
        a, b = cells[..., 0], cells[..., 1]
        inside = (a >= 0) & (b >= 0) & (a < columns) & (b < rows)
        held = self._ground.clearance[a.clip(0, columns - 1), b.clip(0, rows - 1)]
        return np.where(inside, held, -1).astype(np.int32)


def _turned(heading: int, action: Action) -> int:
    return (heading + (1 if action is Action.RIGHT else HEADINGS - 1)) % HEADINGS

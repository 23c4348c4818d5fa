"""Estimate of the heading in which the reference walk of a turn ends, from the agent's own map.

The directions at the start of a turn's instruction are meant from the end of the reference walk of the turn before, and
fewer than half of all walkers end in that heading. The reference is an expert with public rules: it walks by the
cheapest way along the middle of streets to a pose with the object in reach. This module plans that walk by the same
rules, on what the agent has seen.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from arramon_agents.follower.known_ground import KnownGround
from arramon_agents.mapping.body import to_local_frame
from arramon_agents.mapping.ground_map import GroundMap
from arramon_agents.mapping.motion import STEPS, TURN
from arramon_agents.mapping.search import a_star
from arramon_agents.mapping.street_axis import street_axis
from arramon_agents.mapping.walk_costs import TURN_COST
from arramon_client.world import HEADINGS

OBLIQUE_COST = 0.6
"""Extra cost of a step that is not along the streets or across them."""

OFFSET_COST = 0.7
"""Cost of each unit of the object's sideways offset at the end."""

REACH_FROM, REACH_TO, REACH_OFFSET = 0.97, 1.96, 0.45
"""Range of the object's distance ahead at the end, and its maximum sideways offset, in units."""

MAX_EXPANDED = 40_000
"""Maximum number of poses that the search expands."""

QUARTER = HEADINGS // 4
"""Turns of 30 degrees in a right angle."""


def last_heading(ground: GroundMap, target: tuple[float, float]) -> int | None:
    """Return the heading in which an expert's walk from the agent's first pose to an object ends.

    Args:
        ground: the agent's map.
        target: (x, z) of the object, in units.

    Returns:
        Multiples of 30 degrees clockwise from the agent's first heading; None if the map shows no way to the object.
    """
    known = KnownGround(ground)
    left = known.costs_to(target)
    walk = _ReferenceWalk(known, left, target, street_axis(ground))
    start = _WalkPose(0.0, 0.0, 0)
    if not math.isfinite(walk.remaining(start)):
        return None
    found = a_star(walk, start, MAX_EXPANDED)
    return found.states[-1].heading if found.reached else None


class _WalkPose(NamedTuple):
    """A pose of the walk: x and z in units, heading in multiples of 30 degrees, and whether the walk ends there."""

    x: float
    z: float
    heading: int
    is_end: bool = False


@dataclass(frozen=True)
class _ReferenceWalk:
    """Search problem: walk as the expert does until the object is in reach.

    Attributes:
        known: the known ground.
        left: remaining cost to the object by cell of the known ground.
        target: (x, z) of the object.
        axis: direction of the streets, in multiples of 30 degrees, in [0, QUARTER).
    """

    known: KnownGround
    left: list[float]
    target: tuple[float, float]
    axis: int

    def key(self, pose: _WalkPose) -> tuple[int, int, int, bool]:
        """Return the square and heading of a pose."""
        return math.floor(pose.x * 4.0), math.floor(pose.z * 4.0), pose.heading, pose.is_end

    def remaining(self, pose: _WalkPose) -> float:
        """Return the remaining cost from a pose: that of its place, and none at the end."""
        cell = self.known.cell(pose.x, pose.z)
        return 0.0 if pose.is_end else math.inf if cell is None else self.left[cell]

    def is_goal(self, pose: _WalkPose) -> bool:
        """Return whether the walk ends at a pose."""
        return pose.is_end

    def successors(self, pose: _WalkPose) -> Iterator[tuple[_WalkPose, float]]:
        """Yield the end of the walk if the object is in reach, and the poses after a step and after a turn."""
        x, z, heading, _ = pose
        right, ahead = to_local_frame(self.target[0] - x, self.target[1] - z, heading * TURN)
        if REACH_FROM <= ahead <= REACH_TO and abs(right) <= REACH_OFFSET:
            yield _WalkPose(x, z, heading, is_end=True), OFFSET_COST * abs(right)
        sin, cos = STEPS[heading]
        cost = self.known.step_cost(x, z, sin, cos)
        if cost is not None:
            oblique = OBLIQUE_COST if (heading - self.axis) % QUARTER else 0.0
            yield _WalkPose(x + sin, z + cos, heading), cost + oblique
        for turned in (1, HEADINGS - 1):
            yield _WalkPose(x, z, (heading + turned) % HEADINGS), TURN_COST

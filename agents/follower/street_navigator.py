"""Navigator that takes directions as the instruction's writer meant them: from the reference's pose, along streets."""

import math

from arramon_agents.follower.known_ground import street_axis
from arramon_agents.follower.navigation import Navigator
from arramon_agents.follower.reference_walk import last_heading
from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.motion import TURN
from arramon_lang.meaning import Navigation

SLIGHT = ("slightly left", "slightly right")
"""Turns on a street rather than into another one."""

SNAP_WITHIN = math.radians(31.0)
"""Angle in radians between a turn's usual course and a street within which the street is taken for the course meant."""


class StreetNavigator(Navigator):
    """Executor of one navigation instruction that corrects its course by the direction of the streets.

    The instruction's turns are meant on the reference's walk. The agent's walk differs from it by single turns of 30
    degrees, but both walk along the same streets.
    """

    def _course_after(self, direction: str) -> float:
        course = super()._course_after(direction)
        if direction in SLIGHT:
            return course
        axis = street_axis(self._body.ground) * TURN
        along = axis + round((course - axis) / (math.pi / 2)) * (math.pi / 2)
        return along if abs(along - course) < SNAP_WITHIN else course


def make_street_navigator(body: AgentBody, meaning: Navigation, turn: int) -> StreetNavigator:
    """Return the player of a navigation phase that takes directions as they were meant.

    Turn 2 is meant from the heading in which the reference walk of turn 1 ends. It is estimated from the object that
    the agent took there; if it took none, or the map shows no way to it, the agent's own heading counts.
    """
    taken = body.taken if turn > 1 else None
    return StreetNavigator(body, meaning, None if taken is None else last_heading(body.ground, taken))

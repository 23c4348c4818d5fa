"""Walking on the agent's own map, along a planned path to a goal, or along the street."""

import math

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.landmark_memory import MappedLandmark
from arramon_agents.mapping.motion import can_step
from arramon_agents.mapping.target import other_objects
from arramon_agents.mapping.walk_planner import Circle, Goal, Line, PickUp, plan_walk
from arramon_client.agent import Action

MAX_AGE = 10
"""Actions after which a plan is made anew, as the map has grown."""

MAX_MOVED = 0.8
"""Distance in units by which a goal may move before a plan to it is made anew."""

AHEAD_DISTANCE, AHEAD_LEFT = 10.0, 2.5
"""How far along the street to plan, and the distance left at which the next plan is made, in units."""

AHEAD_ASIDE = 3.0
"""Maximum distance from the course of a walk along the street, in units."""

BENDS = (0, -10, 10, -20, 20, -30, 30, -45, 45)
"""Angles off the course in which a street may go on, in degrees."""

BEND_COST = 0.04
"""Units of free ground that a street has to be longer for each degree off the course."""


class MapWalker:
    """Walks on the map, replanning when a plan is old or blocked.

    Args:
        body: the agent's pose and map.

    Attributes:
        goal: (x, z) of the last plan's goal.
    """

    def __init__(self, body: AgentBody) -> None:
        self._body = body
        self._plan: list[Action] = []
        self._plan_age = 0
        self.goal = (math.inf, math.inf)

    @property
    def is_walking(self) -> bool:
        """Whether a plan has actions left."""
        return bool(self._plan)

    def stop(self) -> None:
        """Give up the plan."""
        self._plan = []

    def go_to(self, place: tuple[float, float], radius: float) -> Action | None:
        """Return the next action towards a place; None if the agent is there or cannot get nearer."""
        return self._go(Circle(*place, radius), math.dist(place, self.goal))

    def go_for(self, target: MappedLandmark) -> Action | None:
        """Return the next action towards where a pick-up takes an object; None if the agent cannot get nearer."""
        place = target.x, target.z
        return self._go(PickUp(*place, other_objects(self._body, target)), math.dist(place, self.goal))

    def go_along(self, course: float, distance: float, aside: float) -> Action | None:
        """Return the next action along a course; None if the agent cannot get farther.

        Args:
            course: in radians.
            distance: units along the course, wherever across it.
            aside: maximum distance from the straight line along the course, in units.
        """
        sin, cos = math.sin(course), math.cos(course)
        x, z = self._body.x + distance * sin, self._body.z + distance * cos
        moved = abs((x - self.goal[0]) * sin + (z - self.goal[1]) * cos) if self._plan else math.inf
        return self._go(Line(x, z, course, aside), moved)

    def go_ahead(self, course: float) -> Action | None:
        """Return the next action along the street, near a course in radians; None if it is blocked."""
        body = self._body
        if self._is_usable():
            left = (self.goal[0] - body.x) * math.sin(course) + (self.goal[1] - body.z) * math.cos(course)
            if left > AHEAD_LEFT:
                return self._next()

        def free_distance(degrees: int) -> float:
            return body.ground.free_distance(body.x, body.z, course + math.radians(degrees), AHEAD_DISTANCE)

        bend = max(BENDS, key=lambda degrees: free_distance(degrees) - BEND_COST * abs(degrees))
        reach = free_distance(bend)
        self.stop()
        if reach < 1.75:
            return None
        return self.go_along(course, (reach - 0.25) * math.cos(math.radians(bend)), AHEAD_ASIDE)

    def _go(self, goal: Goal, moved: float) -> Action | None:
        """Return the next action of the plan, made anew if it is old, or its goal has moved by `moved` units."""
        if moved > MAX_MOVED or not self._is_usable():
            self._plan = plan_walk(self._body, goal)
            self.goal, self._plan_age = (goal.x, goal.z), 0
        return self._next()

    def _is_usable(self) -> bool:
        """Return whether the plan has a next action that is not known to be blocked, and is not old."""
        if not self._plan or self._plan_age > MAX_AGE:
            return False
        return self._plan[0] is not Action.FORWARD or can_step(self._body.ground, *self._body.pose)

    def _next(self) -> Action | None:
        self._plan_age += 1
        return self._plan.pop(0) if self._plan else None

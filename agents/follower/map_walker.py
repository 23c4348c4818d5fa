"""Walking on the agent's own map, along a planned path to a goal, or along the street."""

import math
from collections.abc import Callable

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.motion import can_step, find_path
from arramon_client.agent import Action


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

    def go_to(
        self, goal: tuple[float, float], radius: float, is_there: Callable[[float, float, int], bool] | None = None
    ) -> Action | None:
        """Return the next action towards a goal; None if the agent is there or cannot get nearer."""
        body = self._body
        moved = math.hypot(goal[0] - self.goal[0], goal[1] - self.goal[1])
        stale = not self._plan or self._plan_age > 10 or moved > 0.8
        if not stale and self._plan[0] is Action.FORWARD:
            stale = not can_step(body.ground, *body.pose)
        if stale:
            self._plan = find_path(body.ground, body.pose, goal, radius, is_there, body.closed_steps)
            self.goal, self._plan_age = goal, 0
        self._plan_age += 1
        return self._plan.pop(0) if self._plan else None

    def go_ahead(self, course: float) -> Action | None:
        """Return the next action along the street, near a course in radians; None if it is blocked."""
        body = self._body
        if self._plan and body.distance(*self.goal) > 2.5:
            return self.go_to(self.goal, 0.6)

        def worth(degrees: int) -> float:
            reach = body.ground.free_distance(body.x, body.z, course + math.radians(degrees), 10.0)
            return reach - 0.04 * abs(degrees)

        degrees = max((0, -10, 10, -20, 20, -30, 30, -45, 45), key=worth)
        angle = course + math.radians(degrees)
        reach = body.ground.free_distance(body.x, body.z, angle, 10.0)
        if reach < 1.75:
            return None
        far = min(reach - 0.25, 6.0)
        return self.go_to((body.x + far * math.sin(angle), body.z + far * math.cos(angle)), 0.6)

"""Player of one navigation phase by a policy: look around, choose a waypoint or landmark, plan a path to it, repeat."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.landmark_memory import MappedLandmark
from arramon_agents.mapping.motion import can_step
from arramon_agents.mapping.notes import Intent, place
from arramon_agents.mapping.probabilistic_landmark_memory import (
    LandmarkBelief,
    ProbabilisticLandmarkMemory,
    certain_beliefs,
)
from arramon_agents.mapping.target import is_reached, other_objects
from arramon_agents.mapping.walk_planner import Circle, PickUp, plan_walk
from arramon_agents.reading.reader.slots import Row
from arramon_agents.vl_map.features import DIRECTIONS, AgentKnowledge, PolicyInput, policy_input
from arramon_agents.vl_map.options import DISTANCES, WAYPOINTS
from arramon_client.agent import Action
from arramon_client.world import HEADINGS

MAX_MOVES = 3
"""Maximum number of moves between two decisions."""

ARRIVAL_DISTANCE = 0.75
"""Distance to a waypoint at which it counts as reached, in units."""

MAX_TRIED_OPTIONS = 8
"""Number of options to try, best first, before turning on the spot."""

LOOK_BOTH_SIDES = (Action.LEFT, Action.RIGHT, Action.RIGHT, Action.LEFT)
"""Actions that look to both sides."""

RESERVED_STEPS = 70
"""Steps reserved for walking: with fewer left, the agent no longer looks around."""

OptionValues = Callable[[PolicyInput, Sequence[LandmarkBelief]], npt.NDArray[np.float32]]
"""Policy: returns a score for each option; the highest is taken."""


class Decision(NamedTuple):
    """A decision that was made.

    Attributes:
        sample: input of the policy.
        beliefs: landmarks in the input.
        option: the chosen option.
    """

    sample: PolicyInput
    beliefs: Sequence[LandmarkBelief]
    option: int


class MapNavigator:
    """Player of one navigation phase.

    Args:
        body: the agent's pose, map and landmarks.
        rows: rows of the parsed instruction.
        option_values: the policy.
        turn: 1 or 2.
        looks: whether to turn around at the start, and to look to both sides before a decision.

    Attributes:
        decision: the latest decision; None before the first.
    """

    def __init__(
        self, body: AgentBody, rows: Sequence[Row], option_values: OptionValues, turn: int, *, looks: bool = True
    ) -> None:
        self._body, self._rows, self._option_values, self._turn, self._looks = body, rows, option_values, turn, looks
        self._trace = [(body.x, body.z, body.angle)]
        self._plan: list[Action] = [Action.RIGHT] * HEADINGS if looks else []
        self._walked = 0
        self._has_looked = True
        self._missed: list[tuple[float, float]] = []
        self._approached: MappedLandmark | None = None
        self._taking: MappedLandmark | None = None
        self.decision: Decision | None = None
        self._goal: tuple[float, float] | None = None

    def act(self, steps_left: int) -> Action:
        """Return the next action; call it after the body has perceived the observation.

        Args:
            steps_left: steps left in the phase.
        """
        self._follow()
        if self._plan and self._plan[0] is Action.FORWARD and not self._can_step():
            self._plan.clear()
        if self._walked >= MAX_MOVES:
            self._plan.clear()
        if not self._plan:
            if self._approached is not None and is_reached(self._body, self._approached, *self._body.pose):
                self._taking = self._approached
                return Action.INTERACT
            if not self._has_looked and steps_left > RESERVED_STEPS:
                self._has_looked, self._walked = True, 0
                self._plan = list(LOOK_BOTH_SIDES)
            else:
                self._plan = self._decide(steps_left)
                self._has_looked, self._walked = not self._looks, 0
        return self._plan.pop(0)

    def intent(self) -> Intent:
        """Return the waypoint of the latest decision, and the thing to take if it is one."""
        going_for = self._taking or self._approached
        goal = self._goal if going_for is None else (going_for.x, going_for.z)
        take = {} if going_for is None else {"take": {"kind": going_for.label.kind, "colour": going_for.label.colour}}
        return {**take, **({} if goal is None else {"goal": place(*goal)})}

    def _follow(self) -> None:
        """Extend the trace if the agent moved, and remember a failed pick-up, which is not tried again."""
        body = self._body
        x, z, _ = self._trace[-1]
        if math.hypot(body.x - x, body.z - z) > 0.1:
            self._trace.append((body.x, body.z, body.angle))
            self._walked += 1
        else:
            self._trace[-1] = (x, z, body.angle)
        if self._taking is not None:
            self._missed.append((self._taking.x, self._taking.z))
            self._taking = self._approached = None

    def _can_step(self) -> bool:
        return can_step(self._body.ground, *self._body.pose)

    def _decide(self, steps_left: int) -> list[Action]:
        """Return the actions of the best option that has a plan."""
        knowledge = AgentKnowledge(self._body.ground, self._trace, self._beliefs(), steps_left, self._turn)
        sample, beliefs = policy_input(self._rows, knowledge)
        values = self._option_values(sample, beliefs)
        self._approached = self._goal = None
        for option in np.argsort(-values)[:MAX_TRIED_OPTIONS].tolist():
            plan = self._plan_for(option, beliefs)
            if plan:
                self.decision = Decision(sample, beliefs, option)
                return plan
        self.decision = Decision(sample, beliefs, int(values.argmax()))
        return [Action.RIGHT, Action.RIGHT]

    def _beliefs(self) -> list[LandmarkBelief]:
        landmarks = self._body.landmarks
        beliefs = (
            landmarks.beliefs() if isinstance(landmarks, ProbabilisticLandmarkMemory) else certain_beliefs(landmarks)
        )
        return [belief for belief in beliefs if (belief.mark.x, belief.mark.z) not in self._missed]

    def _plan_for(self, option: int, beliefs: Sequence[LandmarkBelief]) -> list[Action]:
        """Return the actions that carry out an option; empty if there is no plan."""
        if option < WAYPOINTS:
            direction, distance = divmod(option, len(DISTANCES))
            angle = self._body.angle + direction * (2.0 * math.pi / DIRECTIONS)
            return self._walk(angle, DISTANCES[distance])
        number = option - WAYPOINTS
        return self._take(beliefs[number].mark) if number < len(beliefs) else []

    def _walk(self, angle: float, distance: float) -> list[Action]:
        body = self._body
        far = max(distance, 1.0)
        goal = body.ground.nearest_free(body.x + far * math.sin(angle), body.z + far * math.cos(angle))
        plan = plan_walk(body, Circle(*goal, ARRIVAL_DISTANCE))
        if Action.FORWARD not in plan:
            return []
        self._goal = goal
        return plan

    def _take(self, mark: MappedLandmark) -> list[Action]:
        body = self._body
        if is_reached(body, mark, *body.pose):
            self._taking = mark
            return [Action.INTERACT]
        self._approached = mark
        plan = plan_walk(body, PickUp(mark.x, mark.z, other_objects(body, mark)))
        if not plan:
            self._approached = None
        return plan

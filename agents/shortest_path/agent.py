"""The shortest-path agent: plans at the start of each phase, and replans after an unexpected pose."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from arramon.v1.evaluation_pb2 import Oracle, Target
from arramon_agents.mapping import room_path as room
from arramon_agents.shortest_path.clearance_map import ClearanceMap
from arramon_agents.shortest_path.motion import CityPose, plan
from arramon_agents.shortest_path.route import Router
from arramon_client.agent import Action, Episode, Observation
from arramon_client.world import TURN, turn_between

TOLERANCE = 0.01
"""Maximum deviation of a pose from the expected one, in units and in degrees."""

MAX_CACHED_GROUNDS = 16
"""Maximum number of sections whose clearance map is cached."""

Pose = tuple[float, float, float]


@dataclass
class _PlannedEpisode:
    """An episode of the shortest-path agent: ground truth, current plan, steps and cells found to be blocked."""

    oracle: Oracle
    phase: tuple[int, str] = (0, "")
    plan: list[Action] = field(default_factory=list)
    expected: Pose | None = None
    blocked_steps: set[tuple[int, int, int]] = field(default_factory=set)
    blocked_cells: set[tuple[int, int]] = field(default_factory=set)


class Agent:
    """Agent that walks to each target on the shortest path that its motion allows, and places it in its target cell.

    It needs the ground truth, so it cannot play hidden splits. (S/P in the paper's table 2.)
    """

    name = "shortest_path"
    sensors = ("pose", "oracle")

    def __init__(self) -> None:
        self._episodes: dict[str, _PlannedEpisode] = {}
        self._grounds: dict[bytes, tuple[ClearanceMap, Router]] = {}

    def begin(self, episode: Episode) -> None:
        """Store the episode's ground truth.

        Raises:
            ValueError: if there is none.
        """
        if episode.oracle is None:
            raise ValueError("shortest_path requires the sensor oracle, which this run does not have")
        self._episodes[episode.episode_id] = _PlannedEpisode(episode.oracle)

    def end(self, episode_id: str) -> None:
        """Discard an episode's ground truth and plan."""
        del self._episodes[episode_id]

    def act(self, observations: Sequence[Observation]) -> list[Action]:
        """Return one action for each observation.

        Raises:
            ValueError: if an observation has no pose.
        """
        return [self._act(observation, self._episodes[observation.episode_id]) for observation in observations]

    def _act(self, observation: Observation, memory: _PlannedEpisode) -> Action:
        if observation.pose is None:
            raise ValueError("shortest_path requires the sensor pose, which this run does not have")
        phase = observation.turn, observation.phase
        if phase != memory.phase:
            memory.phase, memory.plan, memory.expected = phase, [], None
            memory.blocked_steps.clear()
            memory.blocked_cells.clear()
        if memory.expected is None or not _is_close(observation.pose, memory.expected):
            self._plan(observation.pose, memory)
        action = memory.plan.pop(0) if memory.plan else Action.INTERACT
        memory.expected = _after(observation.pose, action, in_room=observation.phase == "assembly")
        return action

    def _plan(self, pose: Pose, memory: _PlannedEpisode) -> None:
        """Make a new plan. If there was a plan, its last step was blocked: exclude it."""
        turn, phase = memory.phase
        target = memory.oracle.targets[turn - 1]
        if phase == "assembly":
            if memory.expected is not None:
                memory.blocked_cells.add((round(memory.expected[0]), round(memory.expected[1])))
            memory.plan = _room_plan(pose, target, memory.blocked_cells)
        else:
            if memory.expected is not None:
                memory.blocked_steps.add(_step_key(pose))
            memory.plan = self._city_plan(pose, target, memory)

    def _city_plan(self, pose: Pose, target: Target, memory: _PlannedEpisode) -> list[Action]:
        ground, router = self._ground(memory.oracle, pose, target)
        goal = target.position.x, target.position.z
        route = router.route(pose[:2], goal)
        if route is None:
            return []
        blocked = memory.blocked_steps
        actions = plan(ground, router, route, CityPose(*pose), goal, lambda start, _: _step_key(start) not in blocked)
        return actions if actions is not None else []

    def _ground(self, oracle: Oracle, pose: Pose, target: Target) -> tuple[ClearanceMap, Router]:
        """Return the clearance map and the router of the oracle's section, cached between episodes."""
        key = b"".join(obstacle.SerializeToString(deterministic=True) for obstacle in oracle.obstacles)
        places = (pose[:2], (target.position.x, target.position.z))
        kept = self._grounds.get(key)
        if kept is None or not all(kept[0].covers(*place) for place in places):
            if len(self._grounds) >= MAX_CACHED_GROUNDS:
                self._grounds.clear()
            ground = ClearanceMap(oracle.obstacles, oracle.agent_radius, include=places)
            kept = self._grounds[key] = ground, Router(ground)
        return kept


def _room_plan(pose: Pose, target: Target, found_blocked: set[tuple[int, int]]) -> list[Action]:
    """Plan a path around the objects in the room if possible, else through them, like some paths of the release."""
    occupied = {(cell.column, cell.row) for cell in target.occupied}
    quarter, turns = room.quarter_and_turns(pose[2])
    start = room.RoomPose(round(pose[0]), round(pose[1]), quarter)
    for blocked in (occupied | found_blocked, found_blocked):
        actions = room.plan(start, (target.cell.column, target.cell.row), blocked)
        if actions is not None:
            return [*turns, *actions]
    return []


def _after(pose: Pose, action: Action, *, in_room: bool) -> Pose:
    """Return the pose after an unblocked action."""
    x, z, heading = pose
    if action == Action.LEFT:
        return x, z, (heading - TURN) % 360.0
    if action == Action.RIGHT:
        return x, z, (heading + TURN) % 360.0
    if action == Action.INTERACT:
        return pose
    if in_room:
        columns, rows = room.AHEAD[round(heading / 90.0) % 4]
        return x + columns, z + rows, heading
    angle = math.radians(heading)
    return x + math.sin(angle), z + math.cos(angle), heading


def _is_close(pose: Pose, expected: Pose) -> bool:
    turned = abs(turn_between(expected[2], pose[2]))
    return math.dist(pose[:2], expected[:2]) <= TOLERANCE and turned <= TOLERANCE


def _step_key(pose: Pose) -> tuple[int, int, int]:
    """Return a key of the step that starts at a pose, robust to rounding."""
    return round(pose[0] * 20), round(pose[1] * 20), round(pose[2]) % 360

"""The agent's pose at each step, from its pose sensor, or else by dead reckoning from its actions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from arramon_client.agent import Action, Observation
from arramon_client.world import COLUMNS, ROOM_START, ROWS, STEP, TURN

Pose = tuple[float, float, float]
"""x, z and heading in degrees clockwise from +z; in the room x and z are column and row."""

START: Pose = (float(ROOM_START[0]), float(ROOM_START[1]), 0.0)
"""The pose at which every assembly phase begins, in cells."""

FROM_POSE, FROM_ACTIONS = "pose", "actions"
"""Sources of a trace: the pose sensor, or dead reckoning."""


@dataclass
class Trace:
    """The agent's current poses in one episode.

    Attributes:
        street: pose in the street; dead reckoning ignores obstacles.
        room: pose in the room; dead reckoning takes only the walls into account.
        source: FROM_POSE once an observation had a pose, otherwise FROM_ACTIONS.
    """

    street: Pose = (0.0, 0.0, 0.0)
    room: Pose = START
    source: str = FROM_ACTIONS

    def at(self, observation: Observation) -> Pose:
        """Return the pose at an observation: the one it contains, else the one by dead reckoning."""
        outdoors = observation.phase == "navigation"
        if not outdoors and observation.phase_step == 0:
            self.room = START
        if observation.pose is not None:
            self.source = FROM_POSE
            if outdoors:
                self.street = observation.pose
            else:
                self.room = observation.pose
        return self.street if outdoors else self.room

    def move(self, observation: Observation, action: int) -> None:
        """Update the pose by the action taken at an observation."""
        if observation.phase == "navigation":
            self.street = _in_street(self.street, action)
        else:
            self.room = _in_room(self.room, action)


def _in_street(pose: Pose, action: int) -> Pose:
    x, z, heading = pose
    if action == Action.FORWARD:
        angle = math.radians(heading)
        return x + STEP * math.sin(angle), z + STEP * math.cos(angle), heading
    return x, z, _turned(heading, action)


def _in_room(pose: Pose, action: int) -> Pose:
    """Return the pose after an action in the room: the agent stays at a wall or at an oblique heading."""
    column, row, heading = pose
    if action != Action.FORWARD:
        return column, row, _turned(heading, action)
    if heading % 90.0:
        return pose
    right, ahead = _AHEAD[round(heading / 90.0) % 4]
    inside = 0 <= column + right < COLUMNS and 0 <= row + ahead < ROWS
    return (column + right, row + ahead, heading) if inside else pose


_AHEAD: Sequence[tuple[int, int]] = ((0, 1), (1, 0), (0, -1), (-1, 0))


def _turned(heading: float, action: int) -> float:
    turn = -TURN if action == Action.LEFT else TURN if action == Action.RIGHT else 0.0
    return (heading + turn) % 360.0

"""The agent's estimate of its pose and surroundings, from its own actions and frames."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.ground_map import GroundMap
from arramon_agents.mapping.landmark_memory import LandmarkMemory
from arramon_agents.mapping.motion import STEPS, TURN, step_key
from arramon_agents.mapping.street_axis import street_axis
from arramon_agents.perception.scan import FrameScanner
from arramon_client.agent import Action, Label, Observation
from arramon_client.world import HEADINGS

if TYPE_CHECKING:
    from arramon_agents.perception.eyes.detected_things import DetectedThing  # It needs PyTorch.


AXIS_STEPS = 5
"""Steps after which the direction of the streets is read from the map again."""


class AgentBody:
    """Odometry, ground map and landmarks in the agent's own frame, where it starts at (0, 0) with heading 0.

    A step was blocked if the depth image did not change.

    Args:
        labels: labels of the segmentation, by index.
        landmarks: memory of landmarks; None for one without attribute probabilities.

    Attributes:
        x, z: the agent's position in units.
        heading: the agent's heading in multiples of 30 degrees clockwise.
        travelled: number of steps that were not blocked.
        ground: the map of the ground.
        landmarks: the landmarks seen.
        closed_steps: `step_key`s of steps that turned out to be blocked.
        taken: (x, z) of the object of the last action, if it was a pick-up by a navigator of rules; else None.
    """

    def __init__(self, labels: Sequence[Label], landmarks: LandmarkMemory | None = None) -> None:
        self.x = self.z = 0.0
        self.heading = 0
        self.travelled = 0
        self.ground = GroundMap()
        self.landmarks = landmarks or LandmarkMemory(labels)
        self.closed_steps: frozenset[tuple[int, int, int]] = frozenset()
        self.taken: tuple[float, float] | None = None
        self._scanner = FrameScanner(labels, self.landmarks.used_labels)
        self._last: Action | None = None
        self._before: npt.NDArray[np.float32] | None = None
        self._axis, self._axis_at = 0, -AXIS_STEPS

    @property
    def street_axis(self) -> int:
        """Direction of the streets by the map, in multiples of 30 degrees: 0, 1 or 2. See `street_axis.street_axis`."""
        if self.travelled >= self._axis_at + AXIS_STEPS:
            self._axis, self._axis_at = street_axis(self.ground), self.travelled
        return self._axis

    @property
    def angle(self) -> float:
        """The heading in radians."""
        return self.heading * TURN

    @property
    def pose(self) -> tuple[float, float, int]:
        """The pose (x, z, heading in multiples of 30 degrees)."""
        return self.x, self.z, self.heading

    def perceive(self, observation: Observation, things: Sequence["DetectedThing"] = ()) -> None:
        """Update pose, map and landmarks by the frame after the last action, and the detected things in it.

        Raises:
            ValueError: if the observation has no depth or no segmentation.
        """
        depth, segmentation = observation.depth, observation.segmentation
        if depth is None or segmentation is None:
            raise ValueError("follower requires the sensors depth and segmentation, which this run does not have")
        coarse = depth[::4, ::4].copy()
        self._move(self._before is not None and np.array_equal(coarse, self._before))
        self._before = coarse
        pose = self.x, self.z, self.angle
        self.ground.add(self._scanner.scan(depth, segmentation, pose))
        self.landmarks.add(self._scanner.sightings(depth, segmentation, pose))
        self.landmarks.add_things(things, pose)

    def record_action(self, action: Action | None) -> None:
        """Record the action that the agent takes now; None at the end of a navigation phase."""
        self._last = action

    def to_local(self, x: float, z: float) -> tuple[float, float]:
        """Transform a place to the agent's own view: units to the right, units ahead."""
        return to_local_frame(x - self.x, z - self.z, self.angle)

    def distance(self, x: float, z: float) -> float:
        """Return the distance to a place, in units."""
        return math.hypot(x - self.x, z - self.z)

    def _move(self, same: bool) -> None:
        if self._last is Action.FORWARD:
            if same:
                sin, cos = STEPS[self.heading]
                self.closed_steps |= {step_key(*self.pose)}
                self.ground.block(self.x + 0.75 * sin, self.z + 0.75 * cos)
            else:
                self.x, self.z = self.x + STEPS[self.heading][0], self.z + STEPS[self.heading][1]
                self.travelled += 1
        elif self._last is Action.LEFT:
            self.heading = (self.heading - 1) % HEADINGS
        elif self._last is Action.RIGHT:
            self.heading = (self.heading + 1) % HEADINGS
        self._last = None


def to_local_frame(dx: float, dz: float, angle: float) -> tuple[float, float]:
    """Rotate a vector into the frame of the direction `angle` (radians): units to the right, units ahead."""
    sin, cos = math.sin(angle), math.cos(angle)
    return dx * cos - dz * sin, dx * sin + dz * cos

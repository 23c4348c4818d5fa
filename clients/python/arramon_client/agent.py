"""The agent contract: what a participant writes against. It is this file, whole."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Protocol

import numpy as np
import numpy.typing as npt

from arramon.v1 import evaluation_pb2


class Action(IntEnum):
    """What an agent can do in one step; the official release's numbers."""

    FORWARD = 0
    LEFT = 1
    RIGHT = 2
    INTERACT = 3


@dataclass(frozen=True)
class Label:
    """What a pixel of a segmentation shows, as far as it can be told by looking.

    Attributes:
        kind: "nothing" (the sky), "road", "pavement", "building", "roof", "cone", "phone_booth", ... "mug", "wall",
            "floor", "start_tile".
        colour: a collectible's, a banner's ground colour, or furniture's where its kind comes in several; otherwise "".
        look: a collectible's pattern, a banner's shape, a building's facade, a wall's look; otherwise "".
    """

    kind: str
    colour: str = ""
    look: str = ""


@dataclass(frozen=True)
class Episode:
    """What an agent is told when an episode begins.

    Attributes:
        episode_id: unique in the split.
        language: "en", "hi", ...
        split: "val_seen", ...
        oracle: ground truth, for privileged agents only (the sensor "oracle", which hidden splits never offer).
        labels: what the numbers of a segmentation mean; empty without the sensor "segmentation".
    """

    episode_id: str
    language: str
    split: str
    oracle: evaluation_pb2.Oracle | None = None
    labels: tuple[Label, ...] = field(default=(), repr=False)


@dataclass(frozen=True)
class Observation:
    """What an agent is given before each step.

    Attributes:
        episode_id: the episode that this belongs to.
        turn: 1 or 2.
        phase: "navigation" or "assembly".
        step: steps taken in this episode so far, over all phases; from 0.
        instruction: of this turn and phase, exactly as it was written.
        phase_step: steps taken in this phase so far; from 0.
        steps_left: steps left in this phase, this one included.
        rgb: (size, size, 3) uint8; None without the sensor "rgb".
        depth: (size, size) float32, metres along the viewing direction, 0 where nothing was hit; None without "depth".
        pose: (x, z, heading in degrees clockwise from +z); in the room x and z are column and row; None without "pose".
        segmentation: (size, size) uint16, each pixel's place in `Episode.labels`; None without "segmentation".
        step_seconds_left: until the action was due, when this left the server; None where there are no clocks. What it
            takes longer is taken from the run's bank; with that empty, the episode's time is over.
        bank_seconds_left: in the run's bank; None where there are no clocks.
    """

    episode_id: str
    turn: int
    phase: str
    step: int
    instruction: str
    phase_step: int
    steps_left: int
    rgb: npt.NDArray[np.uint8] | None = field(default=None, repr=False)
    depth: npt.NDArray[np.float32] | None = field(default=None, repr=False)
    pose: tuple[float, float, float] | None = None
    segmentation: npt.NDArray[np.uint16] | None = field(default=None, repr=False)
    step_seconds_left: float | None = None
    bank_seconds_left: float | None = None


class Agent(Protocol):
    """Plays episodes, many at a time.

    An agent may have an attribute `sensors`, the sensors that it needs, such as `("rgb", "depth")`, which is the
    default; and an attribute `name`, shown on the leaderboard. To be resumable it must act the same when it is shown
    the same observations again: seed what is random by `Episode.episode_id`.
    """

    def begin(self, episode: Episode) -> None:
        """A new episode starts; forget what is remembered of one with the same id."""
        ...

    def act(self, observations: Sequence[Observation]) -> Sequence[int]:
        """One action for each observation, in order; each observation belongs to another open episode."""
        ...

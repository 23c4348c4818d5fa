"""The agent interface: everything that a participant's agent receives and must provide."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from arramon_client.world import Action as Action

if TYPE_CHECKING:
    from arramon.v1 import evaluation_pb2


@dataclass(frozen=True)
class Label:
    """The visible properties of what a segmentation's pixel shows.

    Attributes:
        kind: "nothing" (the sky), "road", "pavement", "building", "roof", "cone", "phone_booth", ... "mug", "wall",
            "floor", "start_tile".
        colour: the colour of a collectible, of a banner's background, or of furniture whose kind has several colours;
            otherwise "".
        look: the pattern of a collectible, the shape of a banner, the facade of a building, the look of a wall;
            otherwise "".
    """

    kind: str
    colour: str = ""
    look: str = ""


@dataclass(frozen=True)
class Episode:
    """The information that an agent gets when an episode begins.

    Attributes:
        episode_id: unique within the split.
        language: "en", "hi", ...
        split: "val_seen", ...
        oracle: ground truth for privileged agents (the sensor "oracle", never offered by hidden splits); else None.
        labels: meaning of a segmentation's values, by index; empty without the sensor "segmentation".
    """

    episode_id: str
    language: str
    split: str
    oracle: "evaluation_pb2.Oracle | None" = None
    labels: tuple[Label, ...] = field(default=(), repr=False)


@dataclass(frozen=True)
class Observation:
    """An agent's observation before a step.

    Attributes:
        episode_id: the episode that the observation belongs to.
        turn: 1 or 2.
        phase: "navigation" or "assembly".
        step: steps taken in this episode so far, over all phases; from 0.
        instruction: instruction of this turn and phase, exactly as written.
        phase_step: steps taken in this phase so far; from 0.
        steps_left: steps left in this phase, including this one.
        rgb: (size, size, 3) uint8; None without the sensor "rgb". All arrays are read-only.
        depth: (size, size) float32, metres along the viewing direction; 0 where nothing was hit, 65.535 at that
            distance and beyond; None without "depth".
        pose: (x, z, heading in degrees clockwise from +z); in the room x and z are column and row; None without "pose".
        segmentation: (size, size) uint16, each pixel's index in `Episode.labels`; None without "segmentation".
        step_seconds_left: seconds until the action is due, as of when the server sent this; None without clocks. Time
            beyond that is taken from the run's bank; once the bank is empty, the episode times out.
        bank_seconds_left: seconds left in the run's bank; None without clocks.
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
    """An agent that plays many episodes at a time.

    An agent may have two attributes: `sensors`, the sensors that it needs (default: `("rgb", "depth")`), and `name`,
    shown on the leaderboard; and a third method, `end`, see `EndingAgent`. To be resumable, it must choose the same
    actions when it gets the same observations again: seed random numbers by `Episode.episode_id`.
    """

    def begin(self, episode: Episode) -> None:
        """Start a new episode; discard any state of an earlier attempt with the same id."""
        ...

    def act(self, observations: Sequence[Observation]) -> Sequence[int]:
        """Return one action for each observation, in order; each observation belongs to a different open episode."""
        ...


class EndingAgent(Agent, Protocol):
    """An agent that discards its state of an episode when the episode has ended."""

    def end(self, episode_id: str) -> None:
        """Discard the state of an episode; it gets no further observation unless `begin` is called again.

        The client calls it once after `begin`, when the episode has ended for any cause (finished, step limit, time
        limit, forfeited, server fault), or another player has taken it over. It is not called if `begin` raised, nor
        for episodes that are open when the client stops. An episode that another player returns, or that another stream
        of the same client takes over, begins again, with its history.
        """
        ...


def end_episode(agent: Agent, episode_id: str) -> None:
    """Call the agent's `end`, if it has one."""
    end = getattr(agent, "end", None)
    if end is not None:
        end(episode_id)

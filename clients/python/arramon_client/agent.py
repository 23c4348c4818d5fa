"""The agent interface: everything that a participant's agent receives and must provide."""

import time
from collections.abc import Awaitable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from arramon_client.world import Action as Action

if TYPE_CHECKING:
    from arramon.v1 import evaluation_pb2

Note = str | Mapping[str, Any]
"""A note beside an action: text, or a mapping that is stored as compact JSON; at most `world.NOTE_BYTES` in UTF-8."""


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
        depth: (size, size) float32, units along the viewing direction; 0 where nothing was hit, 65.535 at that
            distance and beyond; None without "depth".
        pose: (x, z, heading in degrees clockwise from +z); in the room x and z are column and row; None without "pose".
        segmentation: (size, size) uint16, each pixel's index in `Episode.labels`; None without "segmentation".
        step_seconds_left: seconds until the action is due, as of when the server sent this; None without clocks. Time
            beyond that is taken from the run's bank; once the bank is empty, the episode times out.
        bank_seconds_left: seconds left in the run's bank when the server sent this; None without clocks.
        taken: while an episode's history is replayed, the action that was recorded at this step, so that the answer is
            ignored; otherwise None.
        taken_note: the note that was recorded with `taken`; None if there is none.
        arrived: `time.monotonic()` when the client received the observation.
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
    taken: int | None = None
    taken_note: str | None = None
    arrived: float = field(default_factory=time.monotonic, compare=False, repr=False)

    def seconds_left(self) -> float | None:
        """Return how many seconds are left now until the episode times out; None without clocks.

        That is the time left for this step and in the bank when the server sent the observation, less the time since
        it arrived. Other episodes of the run may have used the same bank in the meantime.
        """
        if self.step_seconds_left is None or self.bank_seconds_left is None:
            return None
        waited = time.monotonic() - self.arrived
        return max(0.0, self.step_seconds_left + self.bank_seconds_left - waited)


@dataclass(frozen=True)
class Answer:
    """An action with a note; an agent's `act` may return it in place of an action, also within a batch.

    Notes are stored beside the steps, apart from scores and receipts. They are private to the run's participant unless
    the run is published on an open split.

    Attributes:
        action: the action, 0 to 3.
        note: text, or a mapping for JSON, of at most `world.NOTE_BYTES` bytes in UTF-8; None for none. A note that is
            longer is not stored, and the participant is notified once.
    """

    action: int
    note: Note | None = None


def actions_of(answers: Sequence[int | Answer]) -> list[int]:
    """Return the actions of a batch's answers, for programs that do not keep notes."""
    return [answer.action if isinstance(answer, Answer) else answer for answer in answers]


class Agent(Protocol):
    """An agent that plays many episodes at a time.

    An agent may have two attributes: `sensors`, the sensors that it needs (default: `("rgb", "depth")`), and `name`,
    shown on the leaderboard; and two more methods, `end` and `replay`, see `EndingAgent` and `ReplayingAgent`. To be
    resumable without `replay`, it must choose the same actions when it gets the same observations again: seed random
    numbers by `Episode.episode_id`. An agent that waits, for example for a model behind an API, is an `AsyncAgent`.

    Two more things that any agent may have: an attribute `recorded_arguments`, a mapping from names to texts that the
    run records as the agent's arguments in place of those typed; and a method `run_report()`, which returns a mapping
    that the results file keeps under `agent_report`, such as calls and tokens.

    An agent that computes on one core may have a true attribute `uses_processes`: `arramon-client` then plays with a
    copy of it for each core, in processes of their own. Each copy plays some of the episodes.
    """

    def begin(self, episode: Episode) -> None:
        """Start a new episode; discard any state of an earlier attempt with the same id."""
        ...

    def act(self, observations: Sequence[Observation]) -> Sequence[int | Answer]:
        """Return one action for each observation, in order; each observation belongs to a different open episode.

        Raises:
            StopRun: to stop the run in order, for example because a limit is reached; it can be resumed.
        """
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


class ReplayingAgent(Agent, Protocol):
    """An agent that rebuilds its state from recorded steps, without choosing their actions again."""

    def replay(self, observation: Observation, action: int) -> None:
        """Update the state for a recorded step; called in place of `act` when a run is resumed.

        Args:
            observation: the observation as of the step, with `taken` and `taken_note`.
            action: the recorded action.
        """
        ...


class AsyncAgent(Protocol):
    """An agent that waits for something, such as a model behind an API, and plays each episode at its own pace.

    `act` is a coroutine function for one observation. The client runs all open episodes concurrently in one event loop,
    and never calls `act` for an episode before its last call for that episode has returned. If `act` raises an
    exception, or returns no valid action, only that episode is concerned: the call is repeated as often as
    `Settings.retries` allows, and then `Settings.on_failure` decides.

    Besides `name` and `sensors` an agent may have these methods, ordinary or `async`:

    - `open(run)` is called once before the first episode, with the run as a `RunInfo`, and `close()` once at the end,
      also after an error: the place to open and close a connection that all episodes share.
    - `replay(observation, action)` as in `ReplayingAgent`: with it, resuming a run repeats no call of `act`, except
      those that were in flight.
    - `end(episode_id)` as in `EndingAgent`.
    """

    def begin(self, episode: Episode) -> Awaitable[None] | None:
        """Start a new episode; discard any state of an earlier attempt with the same id. May be `async`."""
        ...

    async def act(self, observation: Observation) -> int | Answer:
        """Return the action for an observation.

        Raises:
            StopRun: to stop the run in order, for example because a limit is reached: calls for other episodes are
                completed, nothing is given up, and the run can be resumed.
        """
        ...


def end_episode(agent: Agent, episode_id: str) -> None:
    """Call the agent's `end`, if it has one."""
    end = getattr(agent, "end", None)
    if end is not None:
        end(episode_id)

"""Events that the engine delivers to a stream. `arramon_server.api` translates them to protocol buffers."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from arramon_client.world import Action
from arramon_server.episodes.episode import Episode
from arramon_server.runs.play.clocks import TimeLeft
from arramon_server.runs.storage.records import Run, RunProgress
from arramon_server.sim.cameras import Frame
from arramon_server.sim.rules import PhaseEnded, State
from arramon_server.sim.scene import Scene
from arramon_server.sim.section_world import EpisodeWorld

Encoding: TypeAlias = Callable[[], Sequence[Any]]
"""Completes the encoding of an observation's images, and returns them as their transport sends them."""


@dataclass(frozen=True, slots=True)
class StreamOpened:
    """The stream has joined its run and resumes these open episodes."""

    run: Run
    progress: RunProgress
    episode_ids: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class EpisodeStarted:
    """An episode was opened on the stream.

    Attributes:
        scene: scene of the episode.
        step: number of steps played before.
    """

    run: Run
    episode: Episode
    scene: Scene
    step: int


@dataclass(frozen=True, slots=True)
class Observed:
    """The agent's observation of a state.

    Attributes:
        world: draws the images.
        steps_left: steps left in the current phase.
        frame: rendered images; None until they are drawn, and without image sensors.
        taken: the action taken in this state if it is part of a history; None in the latest observation.
        time_left: time left for the answer; None in a history, and without time limits.
        encoding: encoding of the frame, which runs in a thread; None if it has not begun.
        taken_note: the note that was stored with `taken`, if any.
    """

    run: Run
    episode: Episode
    world: EpisodeWorld
    state: State
    steps_left: int
    frame: Frame | None = None
    taken: Action | None = None
    time_left: TimeLeft | None = None
    encoding: Encoding | None = None
    taken_note: str | None = None

    def with_images(self, frame: Frame, encoding: Encoding | None = None) -> "Observed":
        """Return this observation with its images. `dataclasses.replace` takes more than twice as long."""
        return Observed(
            self.run,
            self.episode,
            self.world,
            self.state,
            self.steps_left,
            frame,
            self.taken,
            self.time_left,
            encoding,
            self.taken_note,
        )


@dataclass(frozen=True, slots=True)
class PhaseFinished:
    """A phase of an episode ended."""

    episode_id: str
    phase: PhaseEnded


@dataclass(frozen=True, slots=True)
class EpisodeEnded:
    """An episode ended; `ended` is the number of ended episodes of the run, this one included."""

    episode_id: str
    cause: str
    ended: int


@dataclass(frozen=True, slots=True)
class RunEnded:
    """The run is over."""

    run: Run
    progress: RunProgress


@dataclass(frozen=True, slots=True)
class ActionProblem:
    """An action could not be applied; nothing is lost, and the stream stays open.

    Attributes:
        code: the protocol's name, such as "STEP_AHEAD".
        message: what was wrong, and what was expected.
    """

    code: str
    message: str
    episode_id: str
    step: int


Event = StreamOpened | EpisodeStarted | Observed | PhaseFinished | EpisodeEnded | RunEnded | ActionProblem
"""Any event of a stream."""

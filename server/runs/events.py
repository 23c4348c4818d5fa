"""What the engine tells a stream. The API translates these to the wire."""

from dataclasses import dataclass

from server.episodes.episode import Episode
from server.runs.clocks import TimeLeft
from server.runs.records import Progress, Run
from server.sim.cameras import Frame
from server.sim.rules import Action, PhaseEnded, State
from server.sim.scene import Scene


@dataclass(frozen=True, slots=True)
class Opened:
    """The stream stands, and has these episodes back."""

    run: Run
    progress: Progress
    episode_ids: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class EpisodeStarted:
    """An episode is now the stream's, `step` steps into it; `scene` is its section's."""

    run: Run
    episode: Episode
    scene: Scene
    step: int


@dataclass(frozen=True, slots=True)
class Observed:
    """What the agent perceives in a state.

    Attributes:
        steps_left: in the present phase.
        frame: None where the run asked for no images, and until it is drawn.
        taken: in a history, the action that was taken here.
        time_left: for the answer; None in a history, and where there are no clocks.
    """

    run: Run
    episode: Episode
    state: State
    steps_left: int
    frame: Frame | None = None
    taken: Action | None = None
    time_left: TimeLeft | None = None


@dataclass(frozen=True, slots=True)
class PhaseOver:
    """A phase of an episode ended."""

    episode_id: str
    phase: PhaseEnded


@dataclass(frozen=True, slots=True)
class EpisodeEnded:
    """An episode ended; `ended` counts those of the run, this one included."""

    episode_id: str
    cause: str
    ended: int


@dataclass(frozen=True, slots=True)
class RunEnded:
    """All episodes of the run have ended."""

    run: Run
    progress: Progress


@dataclass(frozen=True, slots=True)
class Problem:
    """Something in a request was wrong; nothing was lost.

    Attributes:
        code: the protocol's name for it, such as "STEP_AHEAD".
        message: what was wrong, and what was expected.
    """

    code: str
    message: str
    episode_id: str
    step: int


Event = Opened | EpisodeStarted | Observed | PhaseOver | EpisodeEnded | RunEnded | Problem
"""Anything that a stream can be told."""

"""The interface between environments and the players of their episodes, in this process or on a host over gRPC."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Label, Observation
from arramon_client.world import NAVIGATION, PHASES

REWARDS = ("sparse", "progress", "none")
"""Names of the reward functions."""

EXPERTS = ("reference", "shortest")
"""Names of the experts: along the reference path that the instruction describes, or along the shortest path."""

Images = Mapping[str, npt.NDArray[Any]]
"""Output arrays for the images of an observation, by sensor: "rgb", "depth", "segmentation"."""

Scores = Mapping[str, Mapping[str, float]]
"""Scores by row ("turn 1", "turn 2", and their mean "total") and metric."""


@dataclass(frozen=True)
class TextBounds:
    """Alphabet and maximum length of a split's instructions in one language.

    Attributes:
        alphabet: every character that occurs, sorted.
        longest: length of the longest instruction in characters.
        longest_utf8: length of the longest instruction in UTF-8 bytes.
    """

    alphabet: str
    longest: int
    longest_utf8: int


@dataclass(frozen=True)
class SplitInfo:
    """Description of a split.

    Attributes:
        name: the split's name, for example "val_seen".
        hidden: whether the split is hidden: it then has neither rewards nor scores of single episodes.
        sensors: the sensors that the split offers.
        steps_per_phase: step limit of a phase.
        data_hash: SHA-256 of the split's files, in hexadecimal; empty for randomly drawn tasks.
        texts: alphabet and lengths of the instructions, by language.
        episode_ids: ids of the episodes in the language played, in playing order; None if the host does not list them,
            or the tasks are drawn at random without end.
    """

    name: str
    hidden: bool
    sensors: tuple[str, ...]
    steps_per_phase: int
    data_hash: str
    texts: Mapping[str, TextBounds]
    episode_ids: Sequence[str] | None = field(default=None, repr=False)


@dataclass(frozen=True)
class PlayerSettings:
    """Settings of a player. The backend checks them against its data; `options.make_options` checks the rest.

    Attributes:
        language: language of the instructions.
        split: name of the split.
        sensors: sensors of the observations.
        image_size: side length of images, in pixels.
        reward: one of `REWARDS`.
        expert: one of `EXPERTS`, to get the expert's action with each observation; None for no expert.
        phases: phases that the agent plays; the ground truth is played in the others.
        turn: turn in which the agent begins, 1 or 2; the ground truth is played before it.
        start: phase of that turn in which the agent begins.
        steps_per_phase: step limit of a phase; None for the default of the benchmark or the host.
    """

    language: str
    split: str
    sensors: tuple[str, ...]
    image_size: int
    reward: str = "none"
    expert: str | None = None
    phases: tuple[str, ...] = PHASES
    turn: int = 1
    start: str = NAVIGATION
    steps_per_phase: int | None = None


@dataclass(frozen=True)
class EpisodeEnd:
    """The end of an episode.

    Attributes:
        cause: "AGENT_FINISHED", "STEP_LIMIT", ...
        scores: the episode's scores; None on hidden splits, and on a host until the run has ended.
    """

    cause: str
    scores: Scores | None


@dataclass(frozen=True)
class Step:
    """Result of one action.

    Attributes:
        observation: the next observation; None at the episode's end, and if none was requested.
        steps_left: steps left in the phase; 0 at the episode's end.
        reward: reward of the action, as the settings define it.
        phases_ended: phases that the action ended, as (turn, phase).
        ending: the end of the episode; None if it goes on.
    """

    observation: Observation | None
    steps_left: int
    reward: float = 0.0
    phases_ended: tuple[tuple[int, str], ...] = ()
    ending: EpisodeEnd | None = None


class Player(Protocol):
    """Plays episodes one at a time."""

    @property
    def split(self) -> SplitInfo:
        """The split being played."""

    @property
    def labels(self) -> tuple[Label, ...]:
        """Label of each segmentation value, by index; empty without that sensor, and before the first episode."""

    @property
    def episode_id(self) -> str:
        """Id of the current episode."""

    @property
    def place(self) -> str:
        """Name of the scene around the agent; players in the same scene are rendered fastest one after another."""

    def begin(
        self, episode_id: str | None, seed: int, into: Images | None = None, *, with_images: bool = True
    ) -> Observation:
        """Begin an episode, forfeiting the current one if it has not ended.

        Args:
            episode_id: id of the episode; None for the next episode of a host's run, or for a randomly drawn task.
            seed: seed of a randomly drawn task.
            into: arrays to write the images to, with the shapes and types of `Observation`; new ones by default.
            with_images: whether to render the images; without them, `draw` renders them later.

        Raises:
            UsageError: if there is no such episode.
        """

    def step(self, action: int) -> Step:
        """Apply an action, one of `Action`, and return its result with an observation."""

    def advance(self, action: int) -> Step:
        """Apply an action, and return its result without an observation, which `latest` and `draw` provide."""

    def latest(self, into: Images | None = None) -> Observation:
        """Return the latest observation; its images may be the same arrays as before.

        Args:
            into: as for `begin`.
        """

    def latest_without_images(self) -> Observation:
        """Return the latest observation without its images."""

    def draw(self, into: Images) -> None:
        """Write the images of the latest observation to arrays with the shapes and types of `Observation`."""

    def expert_action(self) -> int:
        """Return the expert's action in the current state.

        Raises:
            UsageError: if there is no expert: on a host, and on hidden splits.
        """

    def map(self, size: int) -> npt.NDArray[np.uint8] | None:
        """Return a map of the current phase seen from above, (size, size, 3); None if the map is not known."""

    def chain_head(self, run_id: str) -> bytes:
        """Return the head of the hash chain over the current episode's actions (`arramon.v1.chain`), 32 bytes."""

    def close(self) -> None:
        """Release all resources. On a host, end the run."""


class Backend(Protocol):
    """Factory of players."""

    def player(self, settings: PlayerSettings) -> Player:
        """Return a new player.

        Raises:
            UsageError: if the settings name something unknown; the message lists what is known.
        """

    def prepare(self) -> None:
        """Do the work that worker processes can share, before they are started."""

    def instructions(self, split: str, language: str) -> list[str]:
        """Return all instruction texts of a split.

        Raises:
            UsageError: if there are none, or they are not known in advance.
        """

"""The contract between an environment and what plays its episodes: in this process, or on a host over gRPC."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Label, Observation
from arramon_client.world import NAVIGATION, PHASES

REWARDS = ("sparse", "progress", "none")
"""Names of the rewards."""

EXPERTS = ("reference", "shortest")
"""Names of the experts: along the reference path, which is what the instruction tells, or the shortest way."""

Images = Mapping[str, npt.NDArray[Any]]
"""Arrays by sensor, into which the images of an observation are written: "rgb", "depth", "segmentation"."""

Scores = Mapping[str, Mapping[str, float]]
"""Value by metric, for "turn 1", "turn 2" and "total", their mean."""


@dataclass(frozen=True)
class TextBounds:
    """What the instructions of a split in one language are made of.

    Attributes:
        alphabet: every character that occurs, sorted.
        longest: characters of the longest instruction.
        longest_utf8: bytes of the longest instruction in UTF-8.
    """

    alphabet: str
    longest: int
    longest_utf8: int


@dataclass(frozen=True)
class SplitInfo:
    """What an environment has to know of a split.

    Attributes:
        name: such as "val_seen".
        hidden: whether there are neither rewards nor scores of single episodes.
        sensors: that may be asked for.
        steps_per_phase: the step limit of a phase.
        data_hash: SHA-256 of the split's files, in hexadecimal; empty for tasks that are drawn.
        texts: by language.
        episode_ids: episodes in the language that is played, in playing order; None if the host does not tell, or the
            episodes are drawn without end.
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
    """What is played, and how. A backend checks them against its data; `options.check_settings` does the rest.

    Attributes:
        language: of the instructions.
        split: name of the split.
        sensors: in the observations.
        image_size: side length of images, in pixels.
        reward: one of `REWARDS`.
        expert: one of `EXPERTS`, if the expert's action is wanted with each observation; None if not.
        phases: that the agent plays; in the others the ground truth is played.
        turn: 1 or 2; what comes before is played by the ground truth.
        start: the phase of that turn with which the agent begins.
        steps_per_phase: the step limit of a phase; None for the benchmark's, or the host's.
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
        scores: None on hidden splits, and on a host as long as the run goes on.
    """

    cause: str
    scores: Scores | None


@dataclass(frozen=True)
class Step:
    """What one action led to.

    Attributes:
        observation: None at the episode's end, as nothing is drawn after it, and where none was asked for.
        steps_left: steps left in the phase; 0 at the episode's end.
        reward: as the settings have it.
        phases_ended: phases that ended with the action, as (turn, phase).
        ending: None unless the episode has ended.
    """

    observation: Observation | None
    steps_left: int
    reward: float = 0.0
    phases_ended: tuple[tuple[int, str], ...] = ()
    ending: EpisodeEnd | None = None


class Player(Protocol):
    """Plays one episode at a time."""

    @property
    def split(self) -> SplitInfo:
        """The split that is played."""

    @property
    def labels(self) -> tuple[Label, ...]:
        """Meaning of a segmentation's values, by index; empty without that sensor, and before the first episode."""

    @property
    def episode_id(self) -> str:
        """Id of the present episode."""

    @property
    def place(self) -> str:
        """Name of the place where the agent is; of players in one place, one after another is drawn fastest."""

    def begin(
        self, episode_id: str | None, seed: int, into: Images | None = None, *, with_images: bool = True
    ) -> Observation:
        """Begin an episode, giving up the present one if it has not ended.

        Args:
            episode_id: the episode; None for the next of the run on a host, and for a drawn task.
            seed: of a drawn task.
            into: arrays to write the images to, of the shapes and types of `Observation`; new ones by default.
            draws: whether the observation has its images; `draw` draws them later.

        Raises:
            UsageError: if there is no such episode.
        """

    def step(self, action: int) -> Step:
        """Apply an action, one of `Action`, and return what it led to, with an observation."""

    def advance(self, action: int) -> Step:
        """Apply an action, and return what it led to, without an observation: `again` and `draw` draw it."""

    def latest(self, into: Images | None = None) -> Observation:
        """Return the latest observation again; its images may be those of the first time.

        Args:
            into: as for `begin`.
        """

    def latest_without_images(self) -> Observation:
        """Return the latest observation without its images."""

    def draw(self, into: Images) -> None:
        """Write the images of the latest observation to arrays, of the shapes and types of `Observation`."""

    def expert_action(self) -> int:
        """Return the expert's action in the present state.

        Raises:
            UsageError: if there is no expert: on a host, and on hidden splits.
        """

    def map(self, size: int) -> npt.NDArray[np.uint8] | None:
        """Return a picture of the present phase from above, (size, size, 3); None where the map is not known."""

    def chain_head(self, run_id: str) -> bytes:
        """Return the head of the hash chain over the actions of the present episode (`arramon.v1.chain`), 32 bytes."""

    def close(self) -> None:
        """Free what is held. On a host, end the run."""


class Backend(Protocol):
    """Something that opens players."""

    def player(self, settings: PlayerSettings) -> Player:
        """Return a player.

        Raises:
            UsageError: if the settings name something that there is not; the message says what there is.
        """

    def prepare(self) -> None:
        """Do once what each process would otherwise do for itself, before processes are started."""

    def instructions(self, split: str, language: str) -> list[str]:
        """Return all instruction texts of a split.

        Raises:
            UsageError: if there are none, or they are not known here.
        """

"""Records of the journal: runs, their progress, claims of episodes, endings, and commit batches."""

from collections.abc import Collection
from dataclasses import asdict, dataclass, field
from datetime import datetime
from typing import Any

from arramon_server.runs.storage.causes import SERVER_FAULT

RUNNING, COMPLETE, CANCELLED = "RUNNING", "COMPLETE", "CANCELLED"
"""States of a run."""

PENDING, OPEN, ENDED = "PENDING", "OPEN", "ENDED"
"""States of an episode in a run."""

CLOSER = ""
"""Player name of an episode that a process has claimed in order to end it with its run."""

LEASE = 5.0
"""Seconds since the last heartbeat after which a worker counts as dead and its claims as released."""


@dataclass(frozen=True, slots=True)
class CodeReference:
    """Source of an agent's code, as declared by its participant; unknown fields are empty.

    Attributes:
        url: address of its repository or page.
        commit: full id of its commit.
        image: digest of its container image, such as "sha256:...", after the image's name and "@" if that is given.
    """

    url: str = ""
    commit: str = ""
    image: str = ""

    def __bool__(self) -> bool:
        """Whether any field is given."""
        return bool(self.url or self.commit or self.image)

    @property
    def digest(self) -> str:
        """Digest of the image without the image's name."""
        return self.image.rpartition("@")[2]

    def named(self) -> dict[str, str]:
        """Return the given values, by field."""
        return {name: value for name, value in asdict(self).items() if value}

    def is_same_code(self, other: "CodeReference") -> bool:
        """Return whether both are the same code: equal commits, or equal images, or else equal addresses without these.

        A commit may be found at several addresses, and several images may be built from it.
        """
        if not (other.commit or other.image):
            return bool(other.url) and self.url == other.url
        return bool(other.commit and self.commit == other.commit) or bool(other.image and self.digest == other.digest)


NO_CODE = CodeReference()


@dataclass(frozen=True, slots=True)
class Run:
    """One evaluation of an agent on a split.

    Attributes:
        participant: displayed name of the participant.
        created_at, ended_at: times in UTC; ended_at is None while the run is being played.
        state: RUNNING, COMPLETE or CANCELLED.
        account: participant whose token created the run; None for an anonymous run.
        step_seconds, bank_seconds: clocks of the run, in seconds; 0 without clocks.
        bank_left: remaining time in the bank, in seconds, as of the last time that a stream was open; None without
            clocks.
        agent_arguments: names and values of the arguments that the agent was created with, sorted by name.
        code: where the agent's code can be found, if its participant named it.
    """

    run_id: str
    participant: str
    agent: str
    split: str
    language: str
    sensors: tuple[str, ...]
    steps_per_phase: int
    data_hash: str
    server_version: str
    state: str
    created_at: datetime
    ended_at: datetime | None = None
    account: str | None = None
    step_seconds: float = 0.0
    bank_seconds: float = 0.0
    bank_left: float | None = None
    agent_arguments: tuple[tuple[str, str], ...] = ()
    code: CodeReference = NO_CODE


@dataclass(frozen=True, slots=True)
class RunProgress:
    """Progress of a run: counts of its episodes, steps and causes.

    Attributes:
        episodes: number of episodes in the run.
        ended: number of episodes that have ended.
        steps: number of recorded steps.
        causes: number of ended episodes by cause.
        images: encodings and sizes in which images were sent, sorted, such as "jpeg90-128" and "lossless-224".
        reoffers: number of times the server offered an episode again because of a fault of its own.
        published: whether the run is listed on the leaderboard.
        thinking_seconds: time between observations and their answers, in ended episodes, see `play.response_times`.
        timed_steps: number of the steps for which that time was measured.
    """

    episodes: int
    ended: int
    steps: int
    causes: dict[str, int]
    images: tuple[str, ...] = ()
    reoffers: int = 0
    published: bool = False
    thinking_seconds: float = 0.0
    timed_steps: int = 0

    @property
    def seconds_a_step(self) -> float | None:
        """Mean time for an answer; None if none was measured."""
        return self.thinking_seconds / self.timed_steps if self.timed_steps else None


@dataclass(frozen=True, slots=True)
class Claim:
    """Claim of an episode that has not ended: its current or last holder.

    Attributes:
        state: PENDING or OPEN.
        player: player name of the stream; None if the episode was never started.
        fence: number that grows with every claim; each write names the one that it holds.
        worker: id of the server process that holds the episode; None after its stream closed.
        idle: seconds since the stream closed, by the service clock, or since the last heartbeat of the worker.
        sent_step: number of the last observation that a closed stream had sent and that was not answered, if any.
        waited: seconds since that observation was sent, by the service clock; None if there is none.
    """

    episode_id: str
    state: str
    player: str | None
    fence: int = 0
    worker: str | None = None
    idle: float = 0.0
    sent_step: int | None = None
    waited: float | None = None

    def seconds_waited(self, step: int) -> float | None:
        """Return the seconds since the observation of a step was sent; None if it was not."""
        return self.waited if step == self.sent_step else None


@dataclass(frozen=True, slots=True)
class EpisodeEnding:
    """End of an episode of a run: cause, steps and scores. `fence` is that of the claim under which it ended.

    `thinking_seconds` and `timed_steps` are as in `RunProgress`; they are 0 in an ending that is read from the journal.
    """

    run_id: str
    episode_id: str
    cause: str
    steps: int
    scores: list[dict[str, float]]
    note: str = ""
    fence: int = 0
    thinking_seconds: float = 0.0
    timed_steps: int = 0

    @property
    def has_played(self) -> bool:
        """Whether the recorded steps count: false for an episode that ended by SERVER_FAULT with 0 steps."""
        return self.steps > 0 or self.cause != SERVER_FAULT


@dataclass(frozen=True, slots=True)
class StepNote:
    """Note that an agent left beside a step."""

    episode_id: str
    step: int
    text: str


@dataclass
class CommitBatch:
    """Rows that one commit writes.

    Attributes:
        steps: parameters of the step rows, see `add_step`.
        notes: rows of notes, each of one of the steps, see `add_note`.
        endings: ends of episodes.
        charges: seconds to subtract from the banks of runs, by run.
        over: final state and time of end of runs, by run; applied to those without episodes left after these endings.
    """

    steps: list[dict[str, Any]] = field(default_factory=list)
    notes: list[dict[str, Any]] = field(default_factory=list)
    endings: list[EpisodeEnding] = field(default_factory=list)
    charges: dict[str, float] = field(default_factory=dict)
    over: dict[str, tuple[str, datetime]] = field(default_factory=dict)

    def add_step(self, run_id: str, episode_id: str, fence: int, step: int, action: int) -> None:
        """Add an action as step number `step` (from 0) of an episode, under the claim with the given fence."""
        self.steps.append({"run": run_id, "episode": episode_id, "epoch": fence, "number": step, "taken": action})

    def add_note(self, run_id: str, episode_id: str, step: int, note: str) -> None:
        """Add a note to a step of this batch."""
        self.notes.append({"run_id": run_id, "episode_id": episode_id, "step": step, "note": note})

    def without(self, episodes: Collection[tuple[str, str]]) -> "CommitBatch":
        """Return a copy without the rows of some episodes, given as pairs of run id and episode id."""
        steps = [step for step in self.steps if (step["run"], step["episode"]) not in episodes]
        notes = [note for note in self.notes if (note["run_id"], note["episode_id"]) not in episodes]
        endings = [ending for ending in self.endings if (ending.run_id, ending.episode_id) not in episodes]
        return CommitBatch(steps, notes, endings, self.charges, self.over)

    def charge(self, run_id: str, seconds: float) -> None:
        """Subtract seconds from the bank of a run; ignored unless positive."""
        if seconds > 0.0:
            self.charges[run_id] = self.charges.get(run_id, 0.0) + seconds

"""What the journal tells of runs: a run, its progress, who holds its episodes, how they ended, what a commit writes."""

from collections.abc import Collection
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from server.runs.causes import SERVER_FAULT

RUNNING, COMPLETE, CANCELLED = "RUNNING", "COMPLETE", "CANCELLED"
"""States of a run."""

PENDING, OPEN, ENDED = "PENDING", "OPEN", "ENDED"
"""States of an episode in a run."""

LEASE = 5.0
"""Seconds after its last sign of life from which on a worker counts as dead, and what it held as left."""


@dataclass(frozen=True, slots=True)
class Run:
    """One agent's passage through a split.

    Attributes:
        participant: the name that it is shown under.
        created_at, ended_at: in UTC; ended_at is None while it is being played.
        state: RUNNING, COMPLETE or CANCELLED.
        account: the participant whose token created it; None for an anonymous one.
        step_seconds, first_step_seconds, bank_seconds: its clocks; 0 where there are none.
        bank_left: what is left of the bank, in seconds; None where there are no clocks.
        active_at: when it was last played, in seconds since 1970; None before that.
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
    first_step_seconds: float = 0.0
    bank_seconds: float = 0.0
    bank_left: float | None = None
    active_at: float | None = None


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run is.

    Attributes:
        images: in which forms its images have travelled, sorted, such as "lossless-224" and "jpeg90-128".
        reoffers: how often the server offered an episode anew by its own fault.
        published: whether the run stands on the leaderboard.
    """

    episodes: int
    ended: int
    steps: int
    causes: dict[str, int]
    images: tuple[str, ...] = ()
    reoffers: int = 0
    published: bool = False


@dataclass(frozen=True, slots=True)
class Claim:
    """An episode of a run that has not ended, and who has it or last had it.

    Attributes:
        state: PENDING or OPEN.
        player: the stream's own name; None where nobody has begun it.
        epoch: grows with every claim; whoever writes names the one that they hold.
        worker: the server process that holds it; None where its stream has left.
        idle: seconds since its stream left, or since its worker was last seen alive.
        waited: seconds that the clock of its present step had run when its stream left.
    """

    episode_id: str
    state: str
    player: str | None
    epoch: int = 0
    worker: str | None = None
    idle: float = 0.0
    waited: float = 0.0


@dataclass(frozen=True, slots=True)
class Ending:
    """How an episode of a run ended; `epoch` is that of the claim under which it did."""

    run_id: str
    episode_id: str
    cause: str
    steps: int
    scores: list[dict[str, float]]
    note: str = ""
    epoch: int = 0

    @property
    def has_played(self) -> bool:
        """Whether its recorded steps count: what the server could not play to its end counts for nothing."""
        return self.steps > 0 or self.cause != SERVER_FAULT


@dataclass
class Batch:
    """What one commit writes.

    Attributes:
        charges: seconds to take from the banks of runs, by run.
    """

    steps: list[dict[str, Any]] = field(default_factory=list)
    endings: list[Ending] = field(default_factory=list)
    charges: dict[str, float] = field(default_factory=dict)

    def add_step(self, run_id: str, episode_id: str, epoch: int, step: int, action: int) -> None:
        """Step number `step` (from 0) of an episode was `action`, under the claim of an epoch."""
        self.steps.append({"run": run_id, "episode": episode_id, "epoch": epoch, "number": step, "taken": action})

    def without(self, episodes: Collection[tuple[str, str]]) -> "Batch":
        """The batch but for some episodes, by run and id."""
        steps = [step for step in self.steps if (step["run"], step["episode"]) not in episodes]
        endings = [ending for ending in self.endings if (ending.run_id, ending.episode_id) not in episodes]
        return Batch(steps, endings, self.charges)

    def charge(self, run_id: str, seconds: float) -> None:
        """A run's bank loses so many seconds."""
        if seconds > 0.0:
            self.charges[run_id] = self.charges.get(run_id, 0.0) + seconds

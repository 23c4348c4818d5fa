"""Description of a run as plain data."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from arramon.v1 import evaluation_pb2

STATES = ("running", "complete", "cancelled")


@dataclass(frozen=True)
class RunInfo:
    """Description of a run.

    Attributes:
        run_id: id of the run, 32 hexadecimal digits.
        state: "running", "complete" or "cancelled".
        split, language, agent, participant: as in `Run.create`.
        sensors: sensors of its observations.
        episodes: number of episodes, the denominator of the scores.
        ended: how many of them have ended.
        steps: steps recorded so far.
        causes: number of ended episodes by cause, such as {"AGENT_FINISHED": 3}.
        created_at, ended_at: RFC 3339, UTC; `ended_at` is empty while the run is open.
        published: whether the run is on the leaderboard.
        agent_arguments: arguments of the agent, by name.
        steps_per_phase: step limit of a phase.
        step_seconds: time limit of a step in seconds; 0 without clocks.
        bank_seconds: seconds in the run's bank, for steps that take longer.
        data_hash: SHA-256 of the split's files, in hexadecimal.
        output: folder of the run's results, in which an agent may keep files of its own; None if there is none.
    """

    run_id: str
    state: str
    split: str
    language: str
    agent: str
    participant: str
    sensors: tuple[str, ...]
    episodes: int
    ended: int
    steps: int
    causes: Mapping[str, int]
    created_at: str
    ended_at: str
    published: bool
    agent_arguments: Mapping[str, str]
    steps_per_phase: int
    step_seconds: float
    bank_seconds: float
    data_hash: str = field(repr=False)
    output: Path | None = None

    @property
    def is_over(self) -> bool:
        """Whether all episodes have ended."""
        return self.state != "running"


def info_of(run: evaluation_pb2.Run) -> RunInfo:
    """Return the description of a run."""
    return RunInfo(
        run_id=run.run_id,
        state=state_of(run),
        split=run.split,
        language=run.language,
        agent=run.agent,
        participant=run.participant,
        sensors=tuple(run.sensors),
        episodes=run.episodes,
        ended=run.episodes_ended,
        steps=run.steps,
        causes=dict(run.causes),
        created_at=run.created_at,
        ended_at=run.ended_at,
        published=run.published,
        agent_arguments={argument.name: argument.value for argument in run.agent_arguments},
        steps_per_phase=run.limits.steps_per_phase,
        step_seconds=run.limits.step_seconds,
        bank_seconds=run.limits.bank_seconds,
        data_hash=run.data_hash,
    )


def state_of(run: evaluation_pb2.Run) -> str:
    """Return a run's state: "running", "complete" or "cancelled"."""
    return evaluation_pb2.RunState.Name(run.state).removeprefix("RUN_STATE_").lower()

"""Results of playing a run: progress, failures of the agent, and the outcome."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from arramon.v1 import evaluation_pb2


@dataclass(frozen=True)
class AgentFailure:
    """One failure of the agent.

    Attributes:
        episode_ids: the episodes that were given up because of it; empty if none was.
        message: description of the failure.
        details: the tail of the agent's traceback; empty if it raised no exception.
    """

    episode_ids: tuple[str, ...]
    message: str
    details: str


@dataclass(frozen=True)
class Progress:
    """Progress of a run.

    Attributes:
        episodes: episodes of the run.
        ended: how many of them have ended, including those that other players played.
        steps: steps taken by this player's agent.
    """

    episodes: int
    ended: int
    steps: int


@dataclass(frozen=True)
class Outcome:
    """The result of playing a run to its end.

    Attributes:
        run: the complete run.
        steps: steps taken by this player's agent.
        failures: the agent's failures.
        problems: descriptions of the problems that the server reported.
        reconnections: number of times that the stream was reopened.
        actions: actions sent, by episode, as in `Player.actions`.
    """

    run: evaluation_pb2.Run
    steps: int
    failures: tuple[AgentFailure, ...]
    problems: tuple[str, ...]
    reconnections: int
    actions: Mapping[str, Sequence[int]] = field(default_factory=dict)

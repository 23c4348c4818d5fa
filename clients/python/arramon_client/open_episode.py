"""State of one open episode: the acts that were sent, and the observations that wait for an answer."""

from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

from arramon.v1 import evaluation_pb2
from arramon_client.agent import Episode


class ReceivedObservation(NamedTuple):
    """An observation as it was received.

    Attributes:
        message: the observation.
        arrived: `time.monotonic()` when it arrived.
    """

    message: evaluation_pb2.Observation
    arrived: float


@dataclass
class OpenEpisode:
    """An open episode of a player.

    Attributes:
        episode: the episode.
        begun: whether the agent's `begin` succeeded.
        answers: the acts sent or recorded, by step.
        inbox: observations that wait for an answer, in order.
        failure: the agent's failure for which the episode is forfeited; empty if there is none.
    """

    episode: Episode
    begun: bool = False
    answers: dict[int, evaluation_pb2.Act] = field(default_factory=dict)
    inbox: deque[ReceivedObservation] = field(default_factory=deque)
    failure: str = ""

    def knows(self, step: int) -> bool:
        """Return whether the observation of a step was answered or is pending."""
        return step in self.answers or any(queued.message.step == step for queued in self.inbox)

    def actions(self) -> tuple[int, ...] | None:
        """Return all actions from the first step on; None if another player took some of them."""
        answers = [self.answers[step] for step in sorted(self.answers)]
        if [answer.step for answer in answers] != list(range(len(answers))):
            return None
        return tuple(answer.action for answer in answers if answer.HasField("action"))

"""Rewards for an agent's actions: "sparse", "progress" or "none" (see `docs/reference/environments.md`)."""

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from arramon_server.episodes.episode import Episode
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.scoring.episode_scores import score_turn
from arramon_server.scoring.trajectory import TurnRecord
from arramon_server.sim.rules import Phase, PhaseEnded, State

PHASE_METRICS = {Phase.NAVIGATION: ("nDTW", "CTC-3"), Phase.ASSEMBLY: ("rPOD@CTC-3", "PTC@CTC-3")}
"""Metrics whose mean is the sparse reward at the end of a phase."""


class Reward(Protocol):
    """Rewards the actions of one episode."""

    def after_action(self, before: State, session: EpisodeSession, ended: Sequence[PhaseEnded]) -> float:
        """Return the reward of the action that was just applied.

        Args:
            before: state before the action.
            session: the episode after the action.
            ended: phases that the action ended.
        """


class NoReward:
    """No reward: always 0."""

    def after_action(self, before: State, session: EpisodeSession, ended: Sequence[PhaseEnded]) -> float:  # noqa: ARG002
        """Return 0."""
        return 0.0


class SparseReward:
    """The paper's metrics at the end of each phase, 0 before: 1 for a perfect phase, 4 for a perfect episode."""

    def after_action(self, before: State, session: EpisodeSession, ended: Sequence[PhaseEnded]) -> float:  # noqa: ARG002
        """Return the mean of `PHASE_METRICS` of each phase that ended."""
        if not ended:
            return 0.0
        turns = session.record().turns
        return sum(_phase_score(turns[end.turn - 1], end.phase) for end in ended)


class ProgressReward:
    """The sparse reward, plus the progress of each action along the ground truth, as a share of its length.

    Progress reduces the remaining distance: to the nearest point of the ground truth's path, and from there along the
    path to its end. Over a phase the shares add up to 1 for an agent that reaches the end of the path.

    Args:
        episode: the episode to play.
    """

    def __init__(self, episode: Episode) -> None:
        self._sparse = SparseReward()
        self._paths = {
            (number, phase): ReferencePath(points)
            for number, turn in enumerate(episode.turns, start=1)
            for phase, points in ((Phase.NAVIGATION, turn.path), (Phase.ASSEMBLY, turn.room_path))
        }

    def after_action(self, before: State, session: EpisodeSession, ended: Sequence[PhaseEnded]) -> float:
        """Return the progress of the action, plus the sparse reward."""
        gained = 0.0
        after = session.state
        if (after.turn, after.phase) == (before.turn, before.phase):
            was, now = agent_place(before), agent_place(after)
            if was != now:
                path = self._paths[before.turn, before.phase]
                gained = (path.remaining(*was) - path.remaining(*now)) / path.length if path.length else 0.0
        return gained + self._sparse.after_action(before, session, ended)


def make_reward(name: str, episode: Episode) -> Reward:
    """Return an episode's reward by name: "sparse", "progress" or "none"."""
    match name:
        case "sparse":
            return SparseReward()
        case "progress":
            return ProgressReward(episode)
        case _:
            return NoReward()


class ReferencePath:
    """A path on the ground, with the remaining distance along it.

    Args:
        points: (x, z) of its corners, at least one.
    """

    def __init__(self, points: Sequence[tuple[float, float]]) -> None:
        corners = np.asarray(points, np.float64).reshape(-1, 2)
        self._starts: npt.NDArray[np.float64] = corners[:-1] if len(corners) > 1 else corners
        self._steps = corners[1:] - corners[:-1] if len(corners) > 1 else np.zeros((1, 2))
        self._lengths = np.hypot(*self._steps.T)
        self._squares = np.maximum(self._lengths**2, 1e-12)
        self._left = self._lengths[::-1].cumsum()[::-1]
        self.length = float(self._lengths.sum())

    def remaining(self, x: float, z: float) -> float:
        """Return the distance from a place to the path's nearest point, plus the length from there to its end.

        If several points are nearest, the last one counts.
        """
        away = np.array((x, z)) - self._starts
        shares = np.clip((away * self._steps).sum(axis=1) / self._squares, 0.0, 1.0)
        off = np.hypot(*(away - shares[:, None] * self._steps).T)
        nearest = int(np.flatnonzero(off <= off.min() + 1e-9)[-1])
        return float(off[nearest] + self._left[nearest] - shares[nearest] * self._lengths[nearest])


def agent_place(state: State) -> tuple[float, float]:
    """Return where the agent is: (x, z) in the city, (column, row) in the room."""
    if state.phase is Phase.ASSEMBLY:
        return float(state.square.column), float(state.square.row)
    return state.pose.x, state.pose.z


def _phase_score(turn: TurnRecord, phase: Phase) -> float:
    scores = score_turn(turn)
    metrics = PHASE_METRICS[phase]
    return math.fsum(scores[name] for name in metrics) / len(metrics)

"""Trajectories of demonstrations, without frames: turn, phase and pose at each step, and the scores."""

from dataclasses import dataclass

from arramon_dataset.demonstrations.sources import EpisodeActions
from arramon_server.episodes.episode import Episode
from arramon_server.errors import ArraMonError
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.storage.causes import AGENT_FINISHED, TIME_LIMIT
from arramon_server.sim.rules import CollisionCheck, Limits, Phase
from arramon_server.sim.view import visible_pose

PHASES = (Phase.NAVIGATION, Phase.ASSEMBLY)

Scores = dict[str, dict[str, float]]
"""Values by metric, under "turn 1" and "turn 2"."""


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Turn, phase and pose of a demonstration's steps, one entry for each action, and the scores.

    Attributes:
        turns: 1 or 2, before the action.
        phases: index in `PHASES`, before the action.
        poses: (x, z, heading) before the action: units and degrees; in the room column and row.
        finished: whether the actions end the episode.
        scores: of the whole episode.
    """

    turns: list[int]
    phases: list[int]
    poses: list[tuple[float, float, float]]
    finished: bool
    scores: Scores


def replay_demonstration(
    source: EpisodeActions, episode: Episode, ground: CollisionCheck, steps_per_phase: int
) -> Trajectory:
    """Replay the actions of a demonstration by the rules, and return the trajectory.

    Raises:
        ArraMonError: if the actions do not fit the episode.
    """
    session = EpisodeSession(episode, ground, Limits(steps_per_phase))
    turns, phases, poses = [], [], []
    try:
        for state, _ in session.replay(source.actions):
            pose = visible_pose(state)
            turns.append(state.turn)
            phases.append(PHASES.index(state.phase))
            poses.append((pose.x, pose.z, pose.heading))
    except ValueError as error:
        raise replay_mismatch(source, f"after {len(turns)} of {len(source.actions)} actions: {error}") from error
    finished = session.state.finished
    return Trajectory(turns, phases, poses, finished, checked_scores(source, session))


def checked_scores(source: EpisodeActions, session: EpisodeSession) -> Scores:
    """Return the scores of a session that has replayed all actions, after checking how it ended.

    Raises:
        ArraMonError: if the episode did not end as recorded.
    """
    if session.state.finished and session.cause != source.cause:
        raise replay_mismatch(source, f"it ends by {session.cause}, expected {source.cause}")
    if not session.state.finished:
        if source.cause == AGENT_FINISHED:
            raise replay_mismatch(source, f"its {len(source.actions)} actions do not end the episode")
        if source.cause == TIME_LIMIT:
            session.end_at_time_limit()
    return {f"turn {number}": dict(turn) for number, turn in enumerate(session.scores().turns, start=1)}


def replay_mismatch(source: EpisodeActions, why: str) -> ArraMonError:
    """Return the error for actions that do not fit their episode."""
    return ArraMonError(f"the actions for episode {source.episode_id!r} do not fit its data: {why}")

"""Episodes played in process with the server's rules and camera, to test instructions with an agent."""

import math
from collections.abc import Generator
from contextlib import closing

import numpy as np

from arramon_client import agent as client
from arramon_client.transport.images import THOUSANDTHS
from arramon_client.world import STEP, Action
from arramon_server.episodes.episode import Episode, Turn
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.scoring.episode_scores import CTC_DISTANCES, EpisodeScores
from arramon_server.scoring.metrics import NDTW_THRESHOLD
from arramon_server.sim.cameras import colourless
from arramon_server.sim.labels import LABELS
from arramon_server.sim.rules import Limits, Phase, State
from arramon_server.sim.section_world import EpisodeWorld

SIZE = 224
"""Pixels along each side of a frame: the server's default."""

AGENT_LABELS = tuple(client.Label(label.kind, label.colour, label.look) for label in LABELS)
"""The segmentation labels as agents receive them."""


class EarlyStop:
    """Early stopping of an episode that can no longer reach a minimum nDTW, and CTC-3 of 1, in every turn.

    nDTW is a function of the cost of aligning the agent's path with the ground truth's; each position adds at least its
    distance from the latter.

    Args:
        turns: of the episode.
        min_ndtw: nDTW that must be exceeded.
    """

    def __init__(self, turns: tuple[Turn, Turn], min_ndtw: float) -> None:
        self._turns = turns
        self._paths = [np.array(turn.path) for turn in turns]
        self._budget = [-math.log(min_ndtw) * NDTW_THRESHOLD * len(turn.path) for turn in turns]
        self._before: State | None = None

    def may_still_pass(self, state: State) -> bool:
        """Return whether both metrics are still within reach after the next state of the episode."""
        before, self._before = self._before, state
        if before is None or before.phase is not Phase.NAVIGATION:
            return True
        number = before.turn - 1
        if (state.turn, state.phase) != (before.turn, before.phase):
            return self._may_be_at_target(number, before)
        if (state.pose.x, state.pose.z) != (before.pose.x, before.pose.z):
            apart = np.hypot(*(self._paths[number] - (state.pose.x, state.pose.z)).T)
            self._budget[number] -= float(apart.min())
        return self._budget[number] > 0.0

    def _may_be_at_target(self, number: int, state: State) -> bool:
        """Return whether CTC-3 may be 1, by the last but one state of a navigation, which one more step may follow."""
        target = self._turns[number].target.position
        far = math.hypot(target.x - state.pose.x, target.z - state.pose.z)
        return far < CTC_DISTANCES["CTC-3"] + STEP


def play(
    agent: client.Agent, episode: Episode, language: str, world: EpisodeWorld, *, size: int = SIZE, split: str = "trial"
) -> EpisodeScores:
    """Play an episode to its end with an agent that needs at most depth and segmentation, and return its scores.

    Args:
        agent: its `begin` is called first, and its `end` last if it has one.
        episode: with instructions in `language`.
        language: code of the language.
        world: the world of the episode.
        size: side length of the frames, in pixels.
        split: name of the split as given to the agent.

    Raises:
        KeyError: if the episode has no instructions in the language.
    """
    session = EpisodeSession(episode, world, Limits())
    for _ in _steps(session, agent, language, world, size, split):
        pass
    return session.scores()


def play_or_stop_early(
    agent: client.Agent, episode: Episode, language: str, world: EpisodeWorld, early_stop: EarlyStop
) -> EpisodeScores | None:
    """Play an episode as `play` does; return None once it can no longer pass."""
    session = EpisodeSession(episode, world, Limits())
    with closing(_steps(session, agent, language, world, SIZE, "trial")) as steps:
        for _ in steps:
            if not early_stop.may_still_pass(session.state):
                return None
    return session.scores()


def _steps(
    session: EpisodeSession, agent: client.Agent, language: str, world: EpisodeWorld, size: int, split: str
) -> Generator[None, None, None]:
    """Play an episode to its end, and yield before each action."""
    episode = session.episode
    agent.begin(client.Episode(episode.episode_id, language, split, labels=AGENT_LABELS))
    try:
        while not session.state.finished:
            yield
            (action,) = client.actions_of(agent.act([_observe(session, language, world, size)]))
            session.apply(Action(action))
    finally:
        client.end_episode(agent, episode.episode_id)


def _observe(session: EpisodeSession, language: str, world: EpisodeWorld, size: int) -> client.Observation:
    """Return the observation of the session's current state."""
    state, episode = session.state, session.episode
    frame = world.render(state, size, segmentation=True, into=colourless(size))
    assert frame.segmentation is not None
    return client.Observation(
        episode_id=episode.episode_id,
        turn=state.turn,
        phase=state.phase.value,
        step=state.step,
        instruction=episode.instruction(language, state.turn, state.phase.value),
        phase_step=state.phase_step,
        steps_left=session.steps_left(state),
        depth=frame.depth.astype(np.float32) * THOUSANDTHS,
        segmentation=frame.segmentation,
    )

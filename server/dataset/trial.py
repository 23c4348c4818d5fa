"""In-process trial of an agent with the server's own rules and camera, to test instructions."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from arramon_client import agent as client
from arramon_client.transport.images import THOUSANDTHS
from server.episodes.episode import Episode
from server.runs.play.session import Session
from server.scoring.episode import EpisodeScores
from server.sim.cameras import Camera
from server.sim.labels import LABELS, places_of
from server.sim.rules import Action, Ground, Limits
from server.sim.view import view

SIZE = 224
"""Pixels along each side of a frame: the server's default."""

AGENT_LABELS = tuple(client.Label(label.kind, label.colour, label.look) for label in LABELS)
"""The segmentation labels as agents receive them."""


@dataclass(frozen=True, slots=True)
class TrialWorld:
    """The physics and cameras in which an episode is played.

    Attributes:
        ground: of the episode's section.
        street: camera of the section.
        room: camera of the room.
    """

    ground: Ground
    street: Camera
    room: Camera


def play(
    agent: client.Agent, episode: Episode, language: str, world: TrialWorld, *, size: int = SIZE, split: str = "trial"
) -> EpisodeScores:
    """Play an episode to its end with an agent that needs at most depth and segmentation, and return its scores.

    Args:
        agent: its `begin` is called first.
        episode: with instructions in `language`.
        language: code of the language.
        world: physics and cameras of the episode's section.
        size: side length of the frames, in pixels.
        split: name of the split as given to the agent.

    Raises:
        KeyError: if the episode has no instructions in the language.
    """
    session = Session(episode, world.ground, Limits())
    places = {False: places_of(world.street.labels), True: places_of(world.room.labels)}
    agent.begin(client.Episode(episode.episode_id, language, split, labels=AGENT_LABELS))
    while not session.state.finished:
        (action,) = agent.act([_observe(session, language, world, places, size)])
        session.apply(Action(action))
    return session.scores()


def _observe(
    session: Session,
    language: str,
    world: TrialWorld,
    places: Mapping[bool, np.ndarray[tuple[int], np.dtype[np.uint16]]],
    size: int,
) -> client.Observation:
    """Return the observation of the session's current state."""
    state, episode = session.state, session.episode
    seen = view(state, episode.layout)
    camera = world.room if seen.indoors else world.street
    frame = camera.render(seen.viewpoint, seen.actors, size, segmentation=True)
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
        segmentation=places[seen.indoors][frame.segmentation],
    )

"""Plays an agent in process, by the server's own rules and camera: what shows whether an instruction leads there."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from arramon_client import agent as client
from arramon_client.images import THOUSANDTHS
from server.episodes.episode import Episode
from server.runs.session import Session
from server.scoring.episode import EpisodeScores
from server.sim.cameras import Camera
from server.sim.labels import LABELS, places_of
from server.sim.rules import Action, Ground, Limits
from server.sim.view import view

SIZE = 224
"""Pixels along each side of a frame: the server's default."""

AGENT_LABELS = tuple(client.Label(label.kind, label.colour, label.look) for label in LABELS)
"""As an agent is told them."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where an episode is played.

    Attributes:
        ground: of its section.
        street: the section's camera.
        room: the room's camera.
    """

    ground: Ground
    street: Camera
    room: Camera


def play(
    agent: client.Agent, episode: Episode, language: str, place: Place, *, size: int = SIZE, split: str = "trial"
) -> EpisodeScores:
    """The scores of an agent that needs no more than depth and segmentation; the episode is played to its end.

    Args:
        agent: begins the episode anew.
        episode: with instructions in `language`.
        language: the code.
        place: of the episode's section.
        size: of the frames.
        split: what the agent is told.

    Raises:
        KeyError: if the episode has no instructions in the language.
    """
    session = Session(episode, place.ground, Limits())
    places = {False: places_of(place.street.labels), True: places_of(place.room.labels)}
    agent.begin(client.Episode(episode.episode_id, language, split, labels=AGENT_LABELS))
    while not session.state.finished:
        (action,) = agent.act([_observe(session, language, place, places, size)])
        session.apply(Action(action))
    return session.scores()


def _observe(
    session: Session,
    language: str,
    place: Place,
    places: Mapping[bool, np.ndarray[tuple[int], np.dtype[np.uint16]]],
    size: int,
) -> client.Observation:
    """What an agent is given in the session's state."""
    state, episode = session.state, session.episode
    seen = view(state, episode.layout)
    camera = place.room if seen.indoors else place.street
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

"""The follower agent with a visual encoder in place of segmentation, and the learned reader in place of the grammar."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from arramon_agents.follower.agent import Agent as Follower
from arramon_agents.follower.room import Find, RoomFollower
from arramon_agents.mapping.body import Body
from arramon_agents.mapping.landmark_beliefs import SeenLandmarks
from arramon_agents.mapping.room_beliefs import SeenRoom
from arramon_agents.perception.encoder import resize
from arramon_agents.perception.eyes.encoder import Eyes
from arramon_agents.perception.eyes.encoder import load as load_eyes
from arramon_agents.perception.eyes.sight import LABELS, Sight, see
from arramon_agents.perception.frame_memory import SeenFrames
from arramon_agents.reading.reader.reader import LearnedReader
from arramon_agents.reading.reader.reader import load as load_reader
from arramon_client.agent import Action, Episode, Observation
from arramon_lang.meaning import Assembly, Navigation

REMEMBERED = 512
"""Frames, of all episodes, whose sights are kept, 0.1 MB each: a third of all frames were seen before."""

Look = Callable[[Observation], Sight]
"""Returns the labels and things seen in an observation."""


class Agent(Follower):
    """Agent that follows instructions by hand-written rules, with learned perception and reading.

    Args:
        eyes: visual encoder; None for the shipped one.
        reader: of instructions, or a file of one; None for the shipped one.
    """

    name = "seeing_follower"
    sensors = ("rgb", "depth")

    def __init__(self, eyes: Eyes | None = None, reader: LearnedReader | str | None = None) -> None:
        super().__init__()
        self._eyes = eyes or load_eyes()
        self._frames = SeenFrames(partial(see, self._eyes), REMEMBERED)
        self._sights: dict[str, Sight] = {}
        self._reader = reader if isinstance(reader, LearnedReader) else load_reader(Path(reader) if reader else None)

    def begin(self, episode: Episode) -> None:
        """Start a new episode."""
        super().begin(replace(episode, labels=LABELS))

    def make_body(self, episode: Episode) -> Body:  # noqa: ARG002 - its labels are the eyes'
        """Return the body that perceives the streets of an episode."""
        return _SeeingBody(self._look, self.make_landmarks())

    def make_landmarks(self) -> SeenLandmarks:
        """Return an empty memory of landmarks."""
        return SeenLandmarks(LABELS)

    def make_room(self, meaning: Assembly, episode: Episode) -> RoomFollower:  # noqa: ARG002
        """Return the player of an assembly phase."""
        return _SeeingRoom(meaning, self._look, self.find_cell)

    def read(self, language: str, text: str, phase: str) -> Navigation | Assembly:  # noqa: ARG002
        """Return the meaning of an instruction, as far as it is understood; the language is not used."""
        return self._reader.read(text, phase)

    def act(self, observations: Sequence[Observation]) -> list[Action]:
        """Return one action for each observation; frames are seen together, which takes less time."""
        images = [_images(observation, self._eyes.image_size) for observation in observations]
        sights = self._frames.find(*(np.stack(part) for part in zip(*images, strict=True)))
        self._sights = {each.episode_id: sight for each, sight in zip(observations, sights, strict=True)}
        return super().act(observations)

    def _look(self, observation: Observation) -> Sight:
        return self._sights[observation.episode_id]


class _SeeingBody(Body):
    """Odometry, map, and memory of named things.

    Args:
        look: perceives an observation.
        landmarks: the memory.
    """

    def __init__(self, look: Look, landmarks: SeenLandmarks) -> None:
        super().__init__(LABELS)
        self.landmarks = self._seen = landmarks
        self._look = look

    def perceive(self, observation: Observation) -> None:
        """Update pose, map and landmarks with the frame after the last action."""
        sight = self._look(observation)
        super().perceive(_seen(observation, sight))
        self._seen.add_things(sight.things, (self.x, self.z, self.angle))


class _SeeingRoom(RoomFollower):
    """Player of one assembly phase.

    Args:
        meaning: of the instruction.
        look: perceives an observation.
        find: returns the cell for the object.
    """

    def __init__(self, meaning: Assembly, look: Look, find: Find) -> None:
        super().__init__(meaning, LABELS, find)
        self._sight = self._seen_room = SeenRoom(LABELS)
        self._look = look

    def act(self, observation: Observation) -> int:
        """Return the next action."""
        sight = self._look(observation)
        if not self._ahead and self._looks_left:
            self._seen_room.add_things(sight.things, self._cell, self._heading)
        return super().act(_seen(observation, sight))


def _seen(observation: Observation, sight: Sight) -> Observation:
    """Return an observation with the labels that were seen, and depth of their size."""
    _, depth = _images(observation, len(sight.labels))
    return replace(observation, depth=depth, segmentation=sight.labels)


def _images(observation: Observation, size: int) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32]]:
    """Return RGB and depth at a size.

    Raises:
        ValueError: if the observation lacks one.
    """
    if observation.rgb is None or observation.depth is None:
        raise ValueError("seeing_follower requires the sensors rgb and depth, which this run does not have")
    rgb, depth = resize(observation.rgb[None], observation.depth[None], size)
    return rgb[0], depth[0]

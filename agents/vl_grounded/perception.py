"""Perception of `vl_grounded`: by the visual encoder from RGB and depth, or without errors from segmentation."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.probabilistic_room_memory import ProbabilisticRoomMemory
from arramon_agents.mapping.room_memory import RoomMemory
from arramon_agents.perception.encoder import GRID, FeatureCache, quantise, resize
from arramon_agents.perception.eyes.encoder import Eyes
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES
from arramon_agents.perception.eyes.predicted_segmentation import LABELS
from arramon_agents.perception.eyes.scores import MIN_LABEL_PIXELS, cells_showing, channels_of
from arramon_agents.vl_grounded.look_around import LookAround
from arramon_client.agent import Episode, Label, Observation
from arramon_client.world import COLLECTIBLES
from arramon_lang.cell_grading import START

Features = npt.NDArray[np.uint8]

SIZE = 224
"""Side length to which segmentations are resized, in pixels."""


class Perception(Protocol):
    """Interface of perception: from observations to cell features, and to named objects in the room.

    Attributes:
        sensors: required sensors.
    """

    sensors: tuple[str, ...]

    def begin(self, episode: Episode) -> None:
        """Start a new episode."""

    def end(self, episode_id: str) -> None:
        """Discard the state of an episode."""

    def features(self, observations: Sequence[Observation]) -> Features:
        """Return the features of the cells of each frame, (B, 7, 7, C).

        Raises:
            ValueError: if an observation lacks a sensor.
        """

    def make_look(self, episode_id: str) -> LookAround:
        """Start a look around in an episode's room."""

    def add(self, look: LookAround, observation: Observation) -> None:
        """Add a frame of the room to a look around.

        Raises:
            ValueError: if the observation lacks a sensor.
        """


class EncoderPerception:
    """Perceives by the visual encoder, from RGB and depth alone.

    Args:
        eyes: the visual encoder.
    """

    sensors: tuple[str, ...] = ("rgb", "depth")

    def __init__(self, eyes: Eyes) -> None:
        self._eyes, self._frames = eyes, FeatureCache(eyes)

    def begin(self, episode: Episode) -> None:
        """Do nothing: no state is kept by episode."""

    def end(self, episode_id: str) -> None:
        """Do nothing."""

    def features(self, observations: Sequence[Observation]) -> Features:
        """Return the features of the cells of each frame, (B, 7, 7, C)."""
        rgb = np.stack([_image_of(observation, "rgb", self.sensors) for observation in observations])
        depth = np.stack([_image_of(observation, "depth", self.sensors) for observation in observations])
        return self._frames.features(rgb, depth)

    def make_look(self, episode_id: str) -> LookAround:  # noqa: ARG002 - the same for all
        """Return a look around in a room."""
        return LookAround(ProbabilisticRoomMemory(LABELS))

    def add(self, look: LookAround, observation: Observation) -> None:
        """Add what is seen in a frame of the room to a look around."""
        assert isinstance(look.room, ProbabilisticRoomMemory)
        rgb, depth = (_image_of(observation, name, self.sensors)[None] for name in self.sensors)
        things = self._eyes.things(*resize(rgb, depth, self._eyes.image_size))[0]
        look.room.add_things(things, START, look.heading)


class SegmentationPerception:
    """Perceives without errors, from depth and segmentation."""

    sensors: tuple[str, ...] = ("depth", "segmentation")

    def __init__(self) -> None:
        self._labels: dict[str, tuple[Label, ...]] = {}

    def begin(self, episode: Episode) -> None:
        """Remember the labels of an episode."""
        self._labels[episode.episode_id] = tuple(episode.labels)

    def end(self, episode_id: str) -> None:
        """Discard the labels of an episode."""
        del self._labels[episode_id]

    def features(self, observations: Sequence[Observation]) -> Features:
        """Return the features of the cells of each frame, (B, 7, 7, C)."""
        found = []
        for observation in observations:
            depth, segmentation = (_image_of(observation, name, self.sensors) for name in self.sensors)
            found.append(true_features(depth, segmentation, self._labels[observation.episode_id]))
        return quantise(np.stack(found))

    def make_look(self, episode_id: str) -> LookAround:
        """Return a look around in an episode's room."""
        return LookAround(RoomMemory(self._labels[episode_id]))

    def add(self, look: LookAround, observation: Observation) -> None:
        """Add what is seen in a frame of the room to a look around."""
        depth, segmentation = (_image_of(observation, name, self.sensors) for name in self.sensors)
        look.room.add(depth, segmentation, START, look.heading)


def true_features(
    depth: npt.NDArray[np.float32], segmentation: npt.NDArray[np.uint16], labels: Sequence[Label]
) -> npt.NDArray[np.float32]:
    """Return the features of a frame that a perfect visual encoder would give, (7, 7, C) in [0, 1].

    Args:
        depth: (size, size) units, 0 where there is nothing.
        segmentation: (size, size), index of each pixel's label.
        labels: the labels.
    """
    nearest = (np.arange(SIZE) * 2 + 1) * len(depth) // (2 * SIZE)
    segmentation, depth = segmentation[nearest][:, nearest], depth[nearest][:, nearest]
    is_shown = cells_showing(segmentation, len(labels)) >= MIN_LABEL_PIXELS
    label_channels = channels_of((label.kind, label.colour, label.look) for label in labels)
    found = (is_shown @ label_channels > 0).astype(np.float32)
    nearness = np.where(depth > 0.0, 1.0 / (1.0 + depth), 0.0).astype(np.float32)
    cells = nearness.reshape(GRID, SIZE // GRID, GRID, SIZE // GRID)
    found[..., CHANNEL_NAMES.index("nearness")] = cells.max((1, 3))
    found[..., CHANNEL_NAMES.index("mean nearness")] = cells.mean((1, 3))
    near = np.zeros(len(labels), np.float32)
    for number in np.unique(segmentation):
        if labels[number].kind in COLLECTIBLES:
            near[number] = 1.0 / (1.0 + depth[segmentation == number].mean())
    found[..., CHANNEL_NAMES.index("nearness of collectible")] = (is_shown * near).max(-1)
    return found


def _image_of(observation: Observation, sensor: str, wanted: Sequence[str]) -> npt.NDArray[Any]:
    image = getattr(observation, sensor)
    if image is None:
        raise ValueError(f"vl_grounded requires the sensors {' and '.join(wanted)}; this run does not have {sensor}")
    return np.asarray(image)

"""Perception by the visual encoder instead of the run's segmentation."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import numpy.typing as npt

from arramon_agents.perception.encoder import resize
from arramon_agents.perception.eyes.encoder import Eyes
from arramon_agents.perception.eyes.predicted_segmentation import predict_percepts
from arramon_agents.perception.frame_cache import FrameCache
from arramon_agents.perception.percept import Percept
from arramon_client.agent import Observation

MAX_CACHED_FRAMES = 512
"""Number of cached frames over all episodes, 0.1 MB each; a third of all frames are repetitions."""


class EyesPerception:
    """Perceives observations by RGB and depth; its labels are `predicted_segmentation.LABELS`.

    Args:
        eyes: the visual encoder.
    """

    def __init__(self, eyes: Eyes) -> None:
        self._size = eyes.image_size
        self._frames = FrameCache(partial(predict_percepts, eyes), MAX_CACHED_FRAMES)

    def __call__(self, observations: Sequence[Observation]) -> list[Percept]:
        """Perceive observations; new frames are encoded as one batch.

        Raises:
            ValueError: if an observation lacks RGB or depth.
        """
        images = [_images(observation, self._size) for observation in observations]
        sights = self._frames.find([rgb for rgb, _ in images], [depth for _, depth in images])
        return [
            Percept(replace(observation, depth=depth, segmentation=sight.labels), sight.things)
            for observation, sight, (_, depth) in zip(observations, sights, images, strict=True)
        ]


def _images(observation: Observation, size: int) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32]]:
    """Return RGB and depth at a size."""
    if observation.rgb is None or observation.depth is None:
        raise ValueError("seeing_follower requires the sensors rgb and depth, which this run does not have")
    rgb, depth = resize(observation.rgb[None], observation.depth[None], size)
    return rgb[0], depth[0]

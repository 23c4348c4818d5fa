"""Pictures of a moment as its agent saw it: colours, depth or segmentation, drawn by the camera of every run."""

import colorsys
from functools import cache

import numpy as np
import numpy.typing as npt
import simplejpeg

from arramon_client.world import DEPTH_UNIT, IMAGE_SENSORS
from arramon_server.sim.labels import LABELS
from arramon_server.sim.rules import State
from arramon_server.sim.section_world import EpisodeWorld

Picture = npt.NDArray[np.uint8]
"""(size, size, 3) uint8."""

KINDS = IMAGE_SENSORS
"""Kinds of pictures: "rgb", "depth" (near is bright) and "segmentation" (a colour for each label)."""

SIZES = (112, 224, 448)
"""Side lengths in which pictures are offered, in pixels."""

QUALITY = 88
"""JPEG quality of pictures for people."""

HALF_BRIGHT = 6.0
"""Depth that is drawn half as bright as the nearest, in units."""

_GOLDEN = 0.618034
"""Step of hues between labels: neighbours in the table get colours far apart."""


def draw(world: EpisodeWorld, state: State, size: int, kind: str = "rgb") -> Picture:
    """Return the agent's view in a state; "rgb" is equal to what an agent with images of `size` received.

    Args:
        world: the episode's world, loaded to be drawn.
        state: a state of the episode.
        size: side length, in pixels.
        kind: one of KINDS.
    """
    frame = world.render(state, size, segmentation=kind == "segmentation")
    if kind == "depth":
        return _grey(frame.depth)
    if frame.segmentation is not None:
        return _palette()[frame.segmentation]
    return frame.rgb


def as_jpeg(picture: Picture, quality: int = QUALITY) -> bytes:
    """Return a picture in JPEG."""
    jpeg: bytes = simplejpeg.encode_jpeg(np.ascontiguousarray(picture), quality=quality, colorspace="RGB")
    return jpeg


def _grey(depth: npt.NDArray[np.uint16]) -> Picture:
    """Return a picture of the depth: white at the camera, black far away and where there is nothing."""
    units = depth.astype(np.float32) * np.float32(DEPTH_UNIT)
    light = np.where(depth == 0, 0.0, HALF_BRIGHT / (HALF_BRIGHT + units))
    return np.repeat(np.rint(255.0 * light).astype(np.uint8)[..., None], 3, axis=2)


@cache
def _palette() -> Picture:
    """Return a colour for each of LABELS, (n, 3)."""
    hues = [(index * _GOLDEN) % 1.0 for index in range(len(LABELS))]
    colours = [
        colorsys.hsv_to_rgb(hue, 0.45 + 0.4 * (index % 2), 0.9 - 0.35 * (index % 3) / 2)
        for index, hue in enumerate(hues)
    ]
    return np.rint(255.0 * np.array(colours)).astype(np.uint8)

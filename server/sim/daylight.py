"""Lighting and sky, the same for every camera: one sun, no shadows, and a sky that pales towards the horizon."""

import math
from functools import cache

import numpy as np
import numpy.typing as npt

from arramon_client.world import FIELD_OF_VIEW

SUN = (0.5, -0.6, 0.9)
"""Direction to the sun, in the scene frame; not of unit length."""

AMBIENT, DIFFUSE = 0.68, 0.40
"""A surface's brightness is AMBIENT plus DIFFUSE times the cosine of the angle between its normal and the sun."""

_ZENITH, _HORIZON, _HAZE = (88, 146, 214), (214, 228, 236), (140, 142, 140)
"""Colours of the sky from 35 degrees up and at the horizon, and of the background below the horizon."""


@cache
def sky(size: int) -> npt.NDArray[np.uint8]:
    """Return the background of a level camera: (size, size, 3) uint8. Read-only: callers share it."""
    half = math.tan(math.radians(FIELD_OF_VIEW) / 2)
    across = ((np.arange(size) + 0.5) / size * 2 - 1) * half
    elevation = np.arctan2(-across[:, None], np.hypot(1.0, across)[None, :])
    height = np.clip(np.sin(elevation) / math.sin(math.radians(35.0)), 0.0, 1.0)[..., None] ** 0.7
    colour = np.asarray(_HORIZON) * (1 - height) + np.asarray(_ZENITH) * height
    image = np.where(elevation[..., None] < 0, _HAZE, np.rint(colour)).astype(np.uint8)
    image.flags.writeable = False
    return image

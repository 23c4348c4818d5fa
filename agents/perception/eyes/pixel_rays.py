"""Ray directions of a frame's pixels, from the field of view."""

import math
from functools import cache

import numpy as np
import numpy.typing as npt

from arramon_client.world import FIELD_OF_VIEW


@cache
def rays(size: int) -> npt.NDArray[np.float32]:
    """Return the slope of each row's rays (down) and of each column's rays (right), (size,) each, per unit ahead."""
    focal = size / 2 / math.tan(math.radians(FIELD_OF_VIEW / 2))
    directions = ((np.arange(size) + 0.5 - size / 2) / focal).astype(np.float32)
    directions.flags.writeable = False
    return directions

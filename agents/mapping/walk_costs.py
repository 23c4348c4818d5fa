"""What steps cost, by the public rules of the expert that walks the ground truth: it keeps to the middle of streets."""

import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt

from arramon_agents.mapping.ground_map import CELL

TURN_COST = 0.11
"""Cost of a turn of 30 degrees, where a step costs 1."""

PREFERRED_CLEARANCE = 2.0
"""Distance in units from everything solid that a walk keeps where possible."""

WALL_COST = 0.9
"""Extra cost of a unit of a walk at a wall; it falls quadratically to 0 at PREFERRED_CLEARANCE."""


def clearance_of(solid: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    """Return the distance of each cell from what is solid, in units, in the shape of `solid`."""
    if not solid.any():
        return np.full(solid.shape, np.inf)
    clearance: npt.NDArray[np.float64] = (distance_transform_edt(~solid) - 0.5) * CELL
    return clearance


def step_costs(clearance: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the cost of a step that ends at each clearance, in the same shape."""
    lack = np.maximum(PREFERRED_CLEARANCE - clearance, 0.0) / PREFERRED_CLEARANCE
    return 1.0 + WALL_COST * lack**2

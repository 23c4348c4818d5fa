"""Depth of frames in units, compiled: numpy converts types through a buffer, which takes twice the time."""

import numpy as np
import numpy.typing as npt

from arramon_client.transport.images import THOUSANDTHS
from server.sim.raster.compilation import cached

_THOUSANDTHS = float(THOUSANDTHS)


def write_units(thousandths: npt.NDArray[np.uint16], units: npt.NDArray[np.float32]) -> None:
    """Write a frame's depth in units, the very numbers that a client decodes from a message.

    Args:
        thousandths: (size, size) uint16, contiguous.
        units: (size, size) float32, contiguous; overwritten.
    """
    _convert(thousandths.reshape(-1), units.reshape(-1))


@cached
def _convert(thousandths: npt.NDArray[np.uint16], units: npt.NDArray[np.float32]) -> None:
    factor = np.float32(_THOUSANDTHS)
    for i in range(thousandths.size):
        units[i] = np.float32(thousandths[i]) * factor

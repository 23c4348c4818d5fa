"""How far an encoder names things; without dependencies, for recipes."""

from typing import NamedTuple


class Reach(NamedTuple):
    """Which things are cut out.

    Attributes:
        ahead: maximum distance ahead of the camera, in units.
        pixels: minimum number of pixels.
    """

    ahead: float
    pixels: int


NEAR, FAR = Reach(16.0, 18), Reach(28.0, 10)
"""Reach of an encoder for single frames; of one for agents that keep a map, to which later views of a thing add."""

REACHES = {"near": NEAR, "far": FAR}
"""Reaches by name."""

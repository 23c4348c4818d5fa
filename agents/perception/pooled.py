"""The visual encoder "pooled": hand-crafted features of colour, nearness and edges, without weights."""

from pathlib import Path

import numpy as np
import numpy.typing as npt

from arramon_agents.perception.encoder import GRID

SIZE = 112
"""Side length of the images; larger images are subsampled."""

CELL = SIZE // GRID

COLOURS = {
    "black": (25, 25, 25),
    "grey": (110, 110, 110),
    "silver": (180, 180, 180),
    "white": (240, 240, 240),
    "red": (200, 30, 30),
    "green": (30, 150, 50),
    "blue": (30, 60, 200),
    "yellow": (240, 210, 30),
    "brown": (120, 70, 35),
    "purple": (130, 40, 160),
    "orange": (240, 120, 20),
    "sky": (150, 195, 235),
}
"""Colours by name; every pixel is assigned to the nearest one."""

RANGES = (1.0, 2.0, 3.5, 6.0, 12.0, 25.0)
"""Upper ends of the depth ranges, in metres; pixels farther away or without depth are in none."""

LEVELS = 32
"""Quantisation levels of a colour component in the table of nearest colours."""


class PooledEncoder:
    """Encoder whose features are shares of pixels by colour, by colour of near pixels, and by depth, and edges."""

    name = "pooled"
    image_size = SIZE
    channel_names = (
        *(f"colour:{name}" for name in COLOURS),
        *(f"near colour:{name}" for name in COLOURS),
        *(f"depth below {limit}" for limit in RANGES),
        "nearness",
        "nearest",
        "edges",
    )
    channels = len(channel_names)
    fingerprint = "pooled-1"

    def __init__(self) -> None:
        steps = (np.arange(LEVELS) + 0.5) * (256 / LEVELS)
        grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(-1, 3)
        centres = np.array(list(COLOURS.values()), np.float64)
        distances = ((grid[:, None] - centres) ** 2).sum(-1)
        self._nearest_colour = distances.argmin(1).astype(np.uint8).reshape(LEVELS, LEVELS, LEVELS)

    def encode(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return (B, 7, 7, C) float32 in [0, 1]: shares of the cell's pixels."""
        small = rgb // (256 // LEVELS)
        colour = self._nearest_colour[small[..., 0], small[..., 1], small[..., 2]]
        near = (depth > 0) & (depth < RANGES[3])
        found = depth > 0
        nearness = np.where(found, 1.0 / (1.0 + depth), 0.0).astype(np.float32)
        edges = np.zeros(depth.shape, np.float32)
        edges[:, :, 1:] = np.abs(np.diff(nearness, axis=2)) > 0.02
        planes = [colour == number for number in range(len(COLOURS))]
        planes += [plane & near for plane in planes]
        planes += [found & (depth < limit) for limit in RANGES]
        shares = [_shares(plane) for plane in planes]
        blocks = _blocks(nearness)
        return np.stack([*shares, blocks.mean((2, 4)), blocks.max((2, 4)), _shares(edges)], -1).astype(np.float32)


def load(source: Path | None = None) -> PooledEncoder:  # noqa: ARG001 - there are no weights to load
    """Return the encoder."""
    return PooledEncoder()


def _blocks(plane: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return the pixels of (B, 112, 112) by cell, (B, 7, 16, 7, 16)."""
    return plane.reshape(len(plane), GRID, CELL, GRID, CELL)


def _shares(plane: npt.NDArray[np.generic]) -> npt.NDArray[np.float32]:
    """Return the share of each cell's pixels that are set, (B, 7, 7)."""
    shares: npt.NDArray[np.float32] = _blocks(plane.astype(np.float32)).mean((2, 4))
    return shares

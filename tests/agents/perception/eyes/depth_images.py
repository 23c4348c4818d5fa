"""Synthetic depth images: flat ground with upright boards."""

import numpy as np

from arramon_agents.perception.eyes.pixel_rays import rays
from arramon_client.world import EYE_HEIGHT

SIZE = 224

Box = tuple[float, float, float, float]
"""A board that stands on the ground: its left and right end, its distance ahead, and its height, in units."""


def image(*boards: Box) -> np.ndarray:
    """The depth of flat ground without end, with upright boards."""
    down, right = rays(SIZE)[:, None], rays(SIZE)[None]
    with np.errstate(divide="ignore"):
        depth = np.broadcast_to(np.where(down > 0.0, EYE_HEIGHT / down, 0.0), (SIZE, SIZE)).astype(np.float32)
    depth = np.where(depth < 60.0, depth, 0.0).astype(np.float32)
    for start, end, ahead, height in sorted(boards, key=lambda board: -board[2]):
        top = EYE_HEIGHT - down * ahead
        depth = np.where((right * ahead > start) & (right * ahead < end) & (top > 0) & (top < height), ahead, depth)
    return depth.astype(np.float32)

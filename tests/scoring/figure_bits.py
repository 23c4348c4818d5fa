"""What one published figure of a hidden split tells of an episode at most: the bound that SECURITY.md states."""

import math

from arramon_server.scoring.disclosure import FLAT, rounding_step


def figure_bits(episodes: int) -> float:
    """Return the bits that one shown mean of a turn tells at most of one episode, whatever else is known.

    An episode moves the exact mean by at most 1 / (episodes * step) of a step, and with it the probability that the
    mean is rounded up: by d = 1 / (episodes * step * (1 - FLAT)) at most, in the first and the last step. That tells
    most where the probability is 0 without the episode: the mean is then rounded up only if the episode scored, and
    that with probability d at most. This is a Z-channel, with the capacity log2(1 + d (1 - d)**((1 - d) / d)).
    """
    step = rounding_step(episodes)
    slope = 1.0 / (1.0 - (2.0 if step == 1.0 else 1.0) * FLAT)  # a single step is the first and the last one
    moved = min(slope / (episodes * step), 1.0)
    if moved == 1.0:
        return 1.0
    return math.log2(1.0 + moved * (1.0 - moved) ** ((1.0 - moved) / moved))

"""Learning-rate schedules: the learning rate of each step of a training."""

import math
from collections.abc import Callable
from itertools import accumulate

Schedule = Callable[[int], float]
"""Returns the learning rate of a step; the first is 0."""


def constant(rate: float) -> Schedule:
    """Return a schedule with the same learning rate at every step."""
    return lambda _step: rate


def warm_up_cosine(rate: float, steps: int, warm_up: float = 0.05) -> Schedule:
    """Return a schedule that rises linearly, then falls along half a cosine to a hundredth.

    Args:
        rate: the highest learning rate.
        steps: number of steps of the training.
        warm_up: share of the steps in which the learning rate rises.
    """

    def rate_at(step: int) -> float:
        done = (step + 1) / steps
        if done < warm_up:
            return rate * done / warm_up
        return rate * (0.01 + 0.99 * 0.5 * (1.0 + math.cos(math.pi * (done - warm_up) / (1 - warm_up))))

    return rate_at


def cosine(rate: float, steps: int) -> Schedule:
    """Return a schedule that falls along half a cosine to 0, like torch's `CosineAnnealingLR`.

    Args:
        rate: the first learning rate.
        steps: number of steps of the training.
    """

    def following(last: float, step: int) -> float:
        """As torch computes it: each rate from the one before."""
        return (1.0 + math.cos(math.pi * step / steps)) / (1.0 + math.cos(math.pi * (step - 1) / steps)) * last

    rates = list(accumulate(range(1, steps), following, initial=rate))
    return rates.__getitem__

"""Learning-rate schedules."""

import math
from collections.abc import Callable
from itertools import accumulate

Schedule = Callable[[int], float]
"""Returns the learning rate of a step; steps count from 0."""


def constant(rate: float) -> Schedule:
    """Return a schedule with a constant learning rate."""
    return lambda _step: rate


def warm_up_cosine(rate: float, steps: int, warm_up: float = 0.05) -> Schedule:
    """Return a schedule with linear warm-up and cosine decay to 1% of the peak.

    Args:
        rate: peak learning rate.
        steps: total number of steps.
        warm_up: share of the steps used for warm-up.
    """

    def rate_at(step: int) -> float:
        done = (step + 1) / steps
        if done < warm_up:
            return rate * done / warm_up
        return rate * (0.01 + 0.99 * 0.5 * (1.0 + math.cos(math.pi * (done - warm_up) / (1 - warm_up))))

    return rate_at


def cosine(rate: float, steps: int) -> Schedule:
    """Return a cosine-decay schedule to 0, like torch's `CosineAnnealingLR`.

    Args:
        rate: initial learning rate.
        steps: total number of steps.
    """

    def following(last: float, step: int) -> float:
        """Compute a rate from the previous one, in the same way as torch, so that rounding is the same."""
        return (1.0 + math.cos(math.pi * step / steps)) / (1.0 + math.cos(math.pi * (step - 1) / steps)) * last

    rates = list(accumulate(range(1, steps), following, initial=rate))
    return rates.__getitem__

"""Moments of faults, spread evenly over an interval, so that few of them hit each part of it."""

import random


def spread_moments(count: int, longest: float, seed: int) -> list[float]:
    """Return one moment from each of `count` equal parts of 0 to `longest` seconds, in a random order."""
    chance = random.Random(seed)
    moments = [(part + chance.random()) * longest / count for part in range(count)]
    chance.shuffle(moments)
    return moments

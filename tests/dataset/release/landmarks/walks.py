"""Paths for the tests of landmarks."""

import numpy as np

from arramon_dataset.paths import STRIDE
from arramon_dataset.release.landmarks.turn_paths import Numbers, TurnPath


def path_along(*corners: tuple[float, float]) -> TurnPath:
    """Return a walk of unit steps along straight streets between corners; its target is a unit beyond its end."""
    places = [np.array(corners[0], dtype=np.float64)]
    for x, z in corners[1:]:
        way = np.array([x, z]) - places[-1]
        steps = round(float(np.hypot(*way)))
        places += [places[-1] + way * (step / steps) for step in range(1, steps + 1)]
    path = np.array(places)
    size = range(len(path))
    start, end = _direction(path[1] - path[0]), _direction(path[-1] - path[-2])
    coming = np.array([_direction(path[at] - path[max(0, at - STRIDE)]) if at else start for at in size])
    last = len(path) - 1
    going = np.array([_direction(path[min(last, at + STRIDE)] - path[at]) if at < last else end for at in size])
    turned = (going - coming + 180.0) % 360.0 - 180.0
    return TurnPath(path, coming, going, turned, path[-1] + (path[-1] - path[-2]))


def _direction(offset: Numbers) -> float:
    return float(np.degrees(np.arctan2(offset[0], offset[1])) % 360.0)

"""The ground truth of a turn as arrays: positions, and directions of arrival and departure."""

from dataclasses import dataclass
from functools import reduce

import numpy as np
import numpy.typing as npt

from arramon_dataset.paths import STRIDE
from arramon_server.episodes.episode import Episode, Turn
from arramon_server.sim.geometry import Pose
from arramon_server.sim.rules import moved

Numbers = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class TurnPath:
    """The path of one turn.

    Attributes:
        places: (n, 2) of (x, z), in units.
        coming: (n,) direction in which the walker arrives, degrees clockwise from +z.
        going: (n,) direction in which the walker leaves.
        turned: (n,) from coming to going, in (-180, 180], positive to the right.
        target: (2,) of (x, z), position of the target.
    """

    places: Numbers
    coming: Numbers
    going: Numbers
    turned: Numbers
    target: Numbers


def paths_of_turns(episode: Episode) -> tuple[TurnPath, TurnPath]:
    """Return the paths of both turns."""
    middle = reduce(moved, episode.turns[0].actions, episode.start)
    end = reduce(moved, episode.turns[1].actions, middle)
    first, second = episode.turns
    return path_of_turn(first, episode.start, middle), path_of_turn(second, middle, end)


def path_of_turn(turn: Turn, start: Pose, end: Pose) -> TurnPath:
    """Return the path of a turn between two poses."""
    places = np.array(turn.path, dtype=np.float64)
    size = np.arange(len(places))
    behind = places - places[np.maximum(size - STRIDE, 0)]
    ahead = places[np.minimum(size + STRIDE, len(places) - 1)] - places
    coming, going = _direction(behind, start.heading), _direction(ahead, end.heading)
    turned = -((coming - going + 180.0) % 360.0 - 180.0)
    target = np.array([turn.target.position.x, turn.target.position.z])
    return TurnPath(places, coming, going, turned, target)


def _direction(offsets: Numbers, otherwise: float) -> Numbers:
    """Return the directions of offsets (n, 2), in degrees clockwise from +z; `otherwise` where there is none."""
    directions = np.degrees(np.arctan2(offsets[:, 0], offsets[:, 1])) % 360.0
    found: Numbers = np.where(np.hypot(offsets[:, 0], offsets[:, 1]) > 0.5, directions, otherwise)
    return found

"""Alignment of two playbacks of one episode by the distance that each has come along the reference paths."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from arramon_server.episodes.episode import Episode, Turn
from arramon_server.playback.moments import Moment
from arramon_server.scoring.trajectory import Point2
from arramon_server.scoring.turn_outcomes import MAX_DEVIATION
from arramon_server.sim.rules import Phase

SAMPLE = 0.25
"""Distance between the points of a reference path to which places are projected, in units."""

WINDOW = 6.0
"""Length of the path ahead to which a place is projected first, in units: so no part is skipped where a path crosses
itself."""

Bin = tuple[int, int, int]
"""Turn, phase (0 for navigation, 1 for assembly), and whole units (cells in the room) come along the reference path."""


class PathProgress:
    """Distance come along a reference path, which never decreases.

    Args:
        path: positions (x, z) of the ground truth, in order.
    """

    def __init__(self, path: Sequence[Point2]) -> None:
        self._points, self._lengths = _sampled(path)
        self._reached = 0

    def advance(self, place: Point2) -> float:
        """Project a place on the rest of the path, if it is near it, and return the distance come so far, in units."""
        ahead = np.hypot(*(self._points[self._reached :] - np.array(place)).T)
        ahead_lengths = self._lengths[self._reached :] - self._lengths[self._reached]
        near = ahead < MAX_DEVIATION
        window = near & (ahead_lengths <= WINDOW)
        if not window.any() and near.any():  # back on the path, further on: its next part that is near
            first = int(near.argmax())
            window = near & (np.arange(len(near)) >= first) & (ahead_lengths <= ahead_lengths[first] + WINDOW)
        if window.any():
            self._reached += int(np.where(window, ahead, np.inf).argmin())
        return float(self._lengths[self._reached])


def align(episode: Episode, first: Sequence[Moment], second: Sequence[Moment]) -> list[tuple[int, int]]:
    """Return pairs of steps of two playbacks of an episode, in order; each step is in at least one pair.

    Both are in the same phase, and have come equally far along its reference path, up to a unit or a cell. The one that
    takes fewer steps for it waits for the other; one that never comes so far stays where it is.
    """
    bins = [_by_bin(episode, moments) for moments in (first, second)]
    pairs, steps = list[tuple[int, int]](), [0, 0]
    for key in sorted(set(bins[0]) | set(bins[1])):
        here = [each.get(key, ()) for each in bins]
        for count in range(max(map(len, here))):
            for side, found in enumerate(here):
                if found:
                    steps[side] = found[min(count, len(found) - 1)]
            pairs.append((steps[0], steps[1]))
    return pairs


def _by_bin(episode: Episode, moments: Sequence[Moment]) -> dict[Bin, list[int]]:
    """Return the steps of a playback by bin."""
    progress = dict[tuple[int, Phase], PathProgress]()
    found = dict[Bin, list[int]]()
    for step, moment in enumerate(moments):
        state = moment.state
        in_room = state.phase is Phase.ASSEMBLY
        key = state.turn, state.phase
        if key not in progress:
            progress[key] = PathProgress(_reference(episode.turns[state.turn - 1], in_room=in_room))
        place = (float(state.square.column), float(state.square.row)) if in_room else (state.pose.x, state.pose.z)
        found.setdefault((state.turn, int(in_room), int(progress[key].advance(place))), []).append(step)
    return found


def _reference(turn: Turn, *, in_room: bool) -> Sequence[Point2]:
    if in_room:
        return [(float(cell.column), float(cell.row)) for cell in turn.room_path]
    return turn.path


def _sampled(path: Sequence[Point2]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return points (n, 2) at most SAMPLE apart along a path, and the distance of each from its start (n,)."""
    points, lengths = [np.array(path[0], dtype=np.float64)], [0.0]
    for start, end in pairwise(np.array(path, dtype=np.float64)):
        length = float(np.hypot(*(end - start)))
        begin = lengths[-1]
        for share in np.linspace(0.0, 1.0, max(int(np.ceil(length / SAMPLE)), 1) + 1)[1:]:
            points.append(start + share * (end - start))
            lengths.append(begin + share * length)
    return np.array(points), np.round(np.array(lengths), 6)

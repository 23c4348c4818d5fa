"""Kernels: likelihood of a thing at each place around the walker, by how a text mentions it ("past", "towards").

A kernel is a table over the walker's own frame: rows ahead, columns to the right. Its greatest value is 1.
"""

from functools import cache

import numpy as np

from arramon_dataset.release.landmarks.mentions import Event
from arramon_dataset.release.landmarks.turn_paths import Numbers, TurnPath

BACK, FRONT, ASIDE = 8.0, 24.0, 12.0
"""Extent of kernels behind, ahead and to each side, in units."""

STEP = 0.5
"""Distance between a kernel's entries, in units."""

BESIDE_TARGET = 1.1
"""Distance of the target from the things that locate it, in units."""

PASSED = 1.7
"""Lateral distance of things that are passed, in units."""

REACHED = 1.5
"""Distance from a thing at which walkers turn or stop, in units."""

SEEN = 20.0
"""Maximum distance of things mentioned as ahead, in units."""

WIDTH = 1.3
"""Standard deviation of all of these distances, in units, mostly due to the walker's position."""

WRONG_SIDE = 0.15
"""Relative likelihood of the side opposite to the stated one."""

PASSING, REACHING = ("past", "beside", "between", "along"), ("to", "at", "before", "after")
"""Manners of `arramon_lang.reading.outline.MANNERS` of things that walkers pass, and of things that they walk up to."""

_AHEAD = np.arange(-BACK, FRONT + STEP, STEP)[:, None]
_RIGHT = np.arange(-ASIDE, ASIDE + STEP, STEP)[None, :]


@cache
def kernel(manner: str, relation: str, side: str) -> Numbers:
    """Return the kernel of a manner, a relation of the object to pick up, and a side, (rows ahead, columns right).

    The frame's origin is the walker, or the object to pick up with manner "target".
    """
    table = _around_target(relation) if manner == "target" else _around_walker(manner)
    if side:
        wrong = _RIGHT < 0 if side == "right" else _RIGHT > 0
        table = np.where(wrong, WRONG_SIDE * table, table)
    scaled: Numbers = table / table.max()
    return scaled


def _around_target(relation: str) -> Numbers:
    if relation in ("left_of", "right_of"):
        return _spot(0.0, BESIDE_TARGET if relation == "left_of" else -BESIDE_TARGET)
    if relation == "behind":
        return _spot(-BESIDE_TARGET, 0.0)
    if relation == "in_front_of":
        return _spot(BESIDE_TARGET, 0.0)
    if relation == "between":
        return _spot(0.0, BESIDE_TARGET) + _spot(0.0, -BESIDE_TARGET)
    return _ring(BESIDE_TARGET)


def is_ahead(manner: str) -> bool:
    """Return whether a manner implies only that a thing is ahead, up to SEEN."""
    return manner not in (*PASSING, *REACHING, "target")


def _around_walker(manner: str) -> Numbers:
    if manner in PASSING:
        return _spot(0.5, PASSED) + _spot(0.5, -PASSED)
    if manner in REACHING:
        return _spot({"after": -REACHED / 2, "before": 2 * REACHED}.get(manner, REACHED), 0.0, WIDTH + 0.3)
    # Seen ahead: in a sector that widens, farther things less often.
    width = WIDTH + 0.12 * np.maximum(_AHEAD, 0.0)
    reach = np.where((_AHEAD > 0.0) & (_AHEAD <= SEEN), np.exp(-np.maximum(_AHEAD, 0.0) / (SEEN / 2)), 0.0)
    sector: Numbers = reach * np.exp(-0.5 * (_RIGHT / width) ** 2)
    return sector


def _spot(ahead: float, right: float, width: float = WIDTH) -> Numbers:
    spot: Numbers = np.exp(-0.5 * (((_AHEAD - ahead) / width) ** 2 + ((_RIGHT - right) / width) ** 2))
    return spot


def _ring(radius: float) -> Numbers:
    ring: Numbers = np.exp(-0.5 * ((np.hypot(_AHEAD, _RIGHT) - radius) / WIDTH) ** 2)
    return ring


def kernel_frames(event: Event, path: TurnPath) -> tuple[Numbers, Numbers]:
    """Return the origins (n, 2) and directions (n,) of a mention's kernel at each place of a path."""
    if event.manner == "target":
        size = len(path.places)
        return np.broadcast_to(path.target, (size, 2)), np.broadcast_to(path.going[-1], (size,))
    if event.manner in PASSING:
        half = np.radians(path.turned) / 2.0
        return path.places, path.coming + np.degrees(half)
    return path.places, path.coming if event.manner in REACHING else path.going


def likelihood(event: Event, origins: Numbers, directions: Numbers, places: Numbers) -> Numbers:
    """Return the kernel's values (n, m) at places (m, 2), for n frames."""
    table = _bordered(event.manner, event.relation, event.side)
    ahead, right = offsets_in_frames(origins, directions, places)
    row, column = (ahead + BACK) / STEP, (right + ASIDE) / STEP
    for index, size in ((row, table.shape[0]), (column, table.shape[1])):  # Places outside fall on the border.
        np.clip(np.rint(index, out=index), -1.0, size - 2.0, out=index)
    values: Numbers = table.ravel()[((row + 1.0) * table.shape[1] + (column + 1.0)).astype(np.intp)]
    return values


@cache
def _bordered(manner: str, relation: str, side: str) -> Numbers:
    """Return a kernel with a border of zeros."""
    return np.pad(kernel(manner, relation, side), 1)


def offsets_in_frames(origins: Numbers, directions: Numbers, places: Numbers) -> tuple[Numbers, Numbers]:
    """Return how far places (m, 2) are ahead and to the right, (n, m) each, in n frames."""
    sin, cos = np.sin(np.radians(directions))[:, None], np.cos(np.radians(directions))[:, None]
    x, z = places[None, :, 0] - origins[:, 0, None], places[None, :, 1] - origins[:, 1, None]
    return x * sin + z * cos, x * cos - z * sin

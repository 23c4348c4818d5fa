"""Which sums of hidden scores can be published without telling of a single episode, and how finely.

`arramon_server.scoring.masking` makes what is shown. Here is how fine it is, what it tells at most, and which groups of
turns are shown at all.

Sums over several groups of turns can be added and subtracted: a group from one that contains it, or several from each
other. All that follows from them linearly lies in the space that the groups span. An episode's leverage in that space
is the share of its scores' variance that the best linear estimate from the published sums explains, if scores are
independent. It is 1 if the sums give the episode's score away. If it is at most 1/LEAST for every episode, then no
combination of the sums is about fewer than LEAST episodes: of a vector over s episodes, one has at least 1/s of the
squared length, and its leverage is at least that.
"""

import numpy as np
import numpy.typing as npt

from arramon_server.scoring.intervals import Floats

LEAST = 20
"""Episodes that every sum, and every combination of sums, is about at least."""

STEPS = (0.01, 0.02, 0.05, 0.1, 0.2)
"""Steps to which published means are rounded."""

COARSE_STEPS = (0.5, 1.0)
"""Further steps for the rows of splits with fewer than 30 episodes."""

LEAST_A_STEP = 6.0
"""Episodes that a step of the rows is about at least, on a split of at least as many."""

FLAT = 0.25
"""Part of the first and of the last step in which means are shown as 0 and 1 for certain: 1.5 episodes at least."""

TEST_NOISE = 4.0
"""Standard deviation of the noise in the sum of a run's scores in paired tests, in episodes."""

GROUP_NOISE = 16.0
"""Standard deviation of the noise in the sum over a group of turns, in turns: a turn may be in many groups."""

FIGURES = 5
"""Figures of a group: the metrics of `arramon_server.scoring.breakdown.SHOWN`."""

GROUP_BITS = 0.15
"""Bits that all groups of one run together may tell of one episode, see `arramon_server.scoring.masking`."""

_NOTHING = 1e-9
"""Squared length up to which a vector counts as zero."""


class PublishedSums:
    """The sums that are published of a hidden split: that of all turns, those of first and of second turns, and groups.

    Args:
        episodes: number of the split's episodes.
    """

    def __init__(self, episodes: int) -> None:
        self._basis: list[Floats] = []
        self._leverage = np.zeros((episodes, 2, 2))
        self._bits = np.zeros(episodes)
        for turn in range(2):
            whole = np.zeros((episodes, 2))
            whole[:, turn] = 1.0
            self._take(self._rest(whole))

    def admit(self, group: npt.NDArray[np.bool_]) -> bool:
        """Return whether a group's sum can be published with all before, and if so count it as published.

        Args:
            group: the turns in the group, (episodes, 2).
        """
        if np.count_nonzero(group.any(axis=1)) < LEAST:
            return False
        if (group == group[0]).all():
            return True  # a row of the score table, shown as there
        bits = self._bits + bits_of(group)
        if bits.max() > GROUP_BITS:
            return False
        rest = self._rest(group.astype(np.float64))
        if np.vdot(rest, rest) > _NOTHING * group.size:  # otherwise it follows from what is published
            if self.leverages(rest).max() > 1.0 / LEAST:
                return False
            self._take(rest)
        self._bits = bits
        return True

    def leverages(self, more: Floats | None = None) -> Floats:
        """Return the leverage of each episode, (episodes,), with `more`, a vector orthogonal to the published ones."""
        found = self._leverage if more is None else self._leverage + _products(more)
        one, other, both = found[:, 0, 0], found[:, 1, 1], found[:, 0, 1]
        # The larger eigenvalue: that of the two turns' combination of which the sums tell most.
        greatest: Floats = (one + other) / 2.0 + np.hypot((one - other) / 2.0, both)
        return greatest

    def _rest(self, vector: Floats) -> Floats:
        """Return the part of a vector that does not follow from the published ones."""
        for _ in range(2):  # twice, as the first time leaves rounding errors
            for other in self._basis:
                vector = vector - np.vdot(other, vector) * other
        return vector

    def _take(self, rest: Floats) -> None:
        self._basis.append(rest / np.sqrt(np.vdot(rest, rest)))
        self._leverage = self._leverage + _products(rest)


def step_of(episodes: int) -> float:
    """Return the step to which the mean of a turn's scores is rounded: the least one of LEAST_A_STEP episodes."""
    return next((step for step in (*STEPS, *COARSE_STEPS) if step >= LEAST_A_STEP / episodes), COARSE_STEPS[-1])


def bits_of(group: npt.NDArray[np.bool_]) -> Floats:
    """Return the bits that the figures of a group tell at most of each episode, (episodes,), see `masking`.

    Args:
        group: the turns in the group, (episodes, 2).
    """
    largest = (group.sum(axis=1) / 2.0) ** 2  # variance of a sum of scores in [0, 1]
    bits: Floats = FIGURES * np.log2(1.0 + largest / GROUP_NOISE**2) / 2.0
    return bits


def _products(vector: Floats) -> Floats:
    """Return for each episode the products of its two components, (episodes, 2, 2), of the vector with length 1."""
    products: Floats = vector[:, :, None] * vector[:, None, :] / np.vdot(vector, vector)
    return products

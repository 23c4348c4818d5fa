"""Disclosure control on hidden splits: which sums of scores are published, with what precision and noise.

`arramon_server.scoring.masking` computes the shown figures. This module sets their precision, bounds the information
that they reveal, and selects the groups of turns that are shown at all.

Sums over groups of turns can be added and subtracted: a group from one that contains it, or several from each other.
All linear combinations of them lie in the space that the groups span. An episode's leverage in that space is the share
of its scores' variance that the best linear estimate from the published sums explains, if scores are independent. It is
1 if the sums reveal the episode's score. If it is at most 1/MIN_EPISODES for every episode, then no combination of the
sums covers fewer than MIN_EPISODES episodes: of a vector over s episodes, one has at least 1/s of the squared length,
and its leverage is at least that.
"""

import numpy as np
import numpy.typing as npt

from arramon_server.scoring.intervals import Floats

MIN_EPISODES = 20
"""Minimum number of episodes in every published sum, and in every combination of sums."""

STEPS = (0.01, 0.02, 0.05, 0.1, 0.2)
"""Steps to which published means are rounded."""

COARSE_STEPS = (0.5, 1.0)
"""Further steps for the rows of splits with fewer than 30 episodes."""

MIN_EPISODES_PER_STEP = 6.0
"""Minimum number of episodes that a rounding step of the rows corresponds to, on a split of at least as many."""

FLAT = 0.25
"""Part of the first and of the last step in which means are always shown as 0 and 1: at least 1.5 episodes."""

TEST_NOISE = 4.0
"""Standard deviation of the noise in the sum of a run's scores in paired tests, in episodes."""

GROUP_NOISE = 16.0
"""Standard deviation of the noise in the sum over a group of turns, in turns: a turn may be in many groups."""

FIGURES_PER_GROUP = 5
"""Number of figures of a group: the metrics of `arramon_server.scoring.breakdown.SHOWN`."""

GROUP_BITS = 0.15
"""Maximum information of all groups of one run about one episode, in bits, see `arramon_server.scoring.masking`."""

_NOTHING = 1e-9
"""Squared length up to which a vector counts as zero."""


class PublishedSums:
    """The published sums of a hidden split: over all turns, over first turns, over second turns, and over groups.

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
        """Return whether a group's sum can be published besides all earlier ones, and if so count it as published.

        Args:
            group: the turns in the group, (episodes, 2).
        """
        if np.count_nonzero(group.any(axis=1)) < MIN_EPISODES:
            return False
        if (group == group[0]).all():
            return True  # a row of the score table, shown as there
        bits = self._bits + disclosed_bits(group)
        if bits.max() > GROUP_BITS:
            return False
        rest = self._rest(group.astype(np.float64))
        if np.vdot(rest, rest) > _NOTHING * group.size:  # otherwise the published sums determine it
            if self.leverages(rest).max() > 1.0 / MIN_EPISODES:
                return False
            self._take(rest)
        self._bits = bits
        return True

    def leverages(self, more: Floats | None = None) -> Floats:
        """Return the leverage of each episode, (episodes,), with a further vector orthogonal to the published ones."""
        found = self._leverage if more is None else self._leverage + _products(more)
        one, other, both = found[:, 0, 0], found[:, 1, 1], found[:, 0, 1]
        # The larger eigenvalue: that of the combination of the two turns about which the sums reveal most.
        greatest: Floats = (one + other) / 2.0 + np.hypot((one - other) / 2.0, both)
        return greatest

    def _rest(self, vector: Floats) -> Floats:
        """Return the component of a vector orthogonal to the published ones."""
        for _ in range(2):  # twice, as the first time leaves rounding errors
            for other in self._basis:
                vector = vector - np.vdot(other, vector) * other
        return vector

    def _take(self, rest: Floats) -> None:
        self._basis.append(rest / np.sqrt(np.vdot(rest, rest)))
        self._leverage = self._leverage + _products(rest)


def rounding_step(episodes: int) -> float:
    """Return the rounding step of a turn's means: the smallest that is at least MIN_EPISODES_PER_STEP episodes."""
    return next(
        (step for step in (*STEPS, *COARSE_STEPS) if step >= MIN_EPISODES_PER_STEP / episodes), COARSE_STEPS[-1]
    )


def disclosed_bits(group: npt.NDArray[np.bool_]) -> Floats:
    """Return an upper bound of the information of a group's figures about each episode in bits, (episodes,).

    Args:
        group: the turns in the group, (episodes, 2).
    """
    largest = (group.sum(axis=1) / 2.0) ** 2  # variance of a sum of scores in [0, 1]
    bits: Floats = FIGURES_PER_GROUP * np.log2(1.0 + largest / GROUP_NOISE**2) / 2.0
    return bits


def _products(vector: Floats) -> Floats:
    """Return the products of each episode's two components of the normalised vector, (episodes, 2, 2)."""
    products: Floats = vector[:, :, None] * vector[:, None, :] / np.vdot(vector, vector)
    return products

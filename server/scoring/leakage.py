"""Changes of agents' scores from one set of episodes to another one, drawn from the same distribution.

The episodes of both sets are different ones, so that they cannot be paired; the agents are. The interval of a change is
for other episodes drawn in the sections of each set (Welch 1947). All agents played the same episodes, so that a set
that is easier by chance moves all of them alike: the change against the others leaves that out.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from server.scoring.intervals import CONFIDENCE, Bounds, Floats, Moments, episode_moments

_SCORE, _DIFFERENCE = 0.25, 1.0
"""Largest variances: of a score in [0, 1], and of a difference of two."""


@dataclass(frozen=True, eq=False, slots=True)
class Scored:
    """Scores of several agents on one set of episodes.

    Attributes:
        scores: score of each agent in each episode, (agents, episodes).
        strata: number of each episode's stratum, (episodes,), as for `intervals.episode_moments`.
    """

    scores: Floats
    strata: npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False, slots=True)
class Changes:
    """Changes of several agents: the newer mean minus the older one.

    Attributes:
        of_each: change of each agent, arrays of shape (agents,).
        against_others: change of each agent minus the mean change of all others; None with one agent.
        mean: mean change over the agents, arrays of shape ().
    """

    of_each: Bounds
    against_others: Bounds | None
    mean: Bounds


def changes(older: Scored, newer: Scored) -> Changes:
    """Return the changes of agents that played both sets, with 95% intervals within [-1, 1].

    Args:
        older, newer: scores of the same agents, in one order; at least one agent.
    """
    agents = len(older.scores)
    each = _change(older, newer, older.scores.T, newer.scores.T, _SCORE)
    mean = _change(older, newer, older.scores.mean(axis=0), newer.scores.mean(axis=0), _SCORE)
    if agents < 2:
        return Changes(each, None, mean)
    share = agents / (agents - 1)  # of an agent's distance from the mean of all, to that from the mean of the others
    before, after = (share * (one.scores - one.scores.mean(axis=0)).T for one in (older, newer))
    return Changes(each, _change(older, newer, before, after, _DIFFERENCE), mean)


def _change(older: Scored, newer: Scored, before: Floats, after: Floats, largest: float) -> Bounds:
    """Return the change of means of scores, (episodes, ...), whose variance is at most `largest`."""
    old, new = episode_moments(before, older.strata), episode_moments(after, newer.strata)
    mean = new.mean - old.mean
    if old.freedom < 1 or new.freedom < 1:
        return Bounds(mean, np.full_like(mean, -1.0), np.ones_like(mean))
    one, other = _variance(old, largest), _variance(new, largest)
    freedom = (one + other) ** 2 / (one**2 / old.freedom + other**2 / new.freedom)
    half = stdtrit(freedom, 0.5 + CONFIDENCE / 2.0) * np.sqrt(one + other)
    return Bounds(mean, np.maximum(mean - half, -1.0), np.minimum(mean + half, 1.0))


def _variance(moments: Moments, largest: float) -> Floats:
    """Return the variance of a mean, as if one more episode had shown the largest variance."""
    shown = moments.variance * moments.episodes * moments.freedom + largest
    variance: Floats = shown / (moments.freedom + 1.0) / moments.episodes
    return variance

"""Comparison of walks that must not depend on the number of processes."""

from collections.abc import Sequence

import numpy as np

from arramon_agents.simulated.episode_walks import EpisodeWalk


def assert_same_walks(some: Sequence[EpisodeWalk], others: Sequence[EpisodeWalk]) -> None:
    """Assert that two sequences of walks are equal, and have decisions."""
    for one, two in zip(some, others, strict=True):
        assert one.picked == two.picked
        assert [each.label for each in one.decisions] == [each.label for each in two.decisions]
        for ours, theirs in zip(one.decisions, two.decisions, strict=True):
            for a, b in zip(ours.sample, theirs.sample, strict=True):
                assert np.array_equal(np.asarray(a), np.asarray(b))
    assert any(each.decisions for each in some)

"""Changes of agents from one set of episodes to another: against scipy, and by simulation."""

import numpy as np
import pytest
import scipy  # which loads scipy.stats when a test asks for it

from server.scoring.leakage import Scored, changes


def scored(scores: np.ndarray) -> Scored:
    return Scored(scores, np.zeros(scores.shape[1], np.intp))


def test_a_change_is_that_of_welch_with_one_more_episode() -> None:
    rng = np.random.default_rng(0)
    older, newer = rng.random((3, 400)), rng.random((3, 500)) * 0.8
    found = changes(scored(older), scored(newer))
    assert found.of_each.mean == pytest.approx(newer.mean(axis=1) - older.mean(axis=1))
    assert float(found.mean.mean) == pytest.approx(newer.mean() - older.mean())
    for at in range(3):
        plain = scipy.stats.ttest_ind(newer[at], older[at], equal_var=False).confidence_interval()
        assert (found.of_each.low[at], found.of_each.high[at]) == pytest.approx((plain.low, plain.high), abs=1e-3)
        assert found.of_each.low[at] < plain.low


def test_against_the_others_leaves_out_what_moves_all() -> None:
    rng = np.random.default_rng(1)
    base = rng.random((4, 600)) * 0.5
    harder = 0.3 * rng.random(600)  # the same for all agents: the new episodes' own difficulty
    newer = rng.random((4, 600)) * 0.5 + 0.3 - harder
    newer[2] -= 0.15  # it had learned the old ones
    found = changes(scored(base), scored(newer))
    assert found.against_others is not None
    apart = found.against_others
    before, after = base.mean(axis=1), newer.mean(axis=1)
    for at in range(4):
        rest = [other for other in range(4) if other != at]
        expected = (after[at] - before[at]) - np.mean(after[rest] - before[rest])
        assert apart.mean[at] == pytest.approx(expected)
    assert apart.high[2] < 0.0
    assert all(apart.high[at] > 0.0 for at in (0, 1, 3))


def test_one_agent_has_no_others_and_one_episode_tells_nothing() -> None:
    found = changes(scored(np.ones((1, 5))), scored(np.zeros((1, 5))))
    assert found.against_others is None
    assert (float(found.mean.mean), float(found.of_each.low[0])) == (-1.0, -1.0)
    alone = changes(scored(np.ones((2, 1))), scored(np.zeros((2, 5))))
    assert (float(alone.mean.low), float(alone.mean.high)) == (-1.0, 1.0)


@pytest.mark.parametrize(("mean", "episodes"), [(0.5, 60), (0.1, 200), (0.9, 300)])
def test_intervals_hold_the_truth_as_often_as_they_say(mean: float, episodes: int) -> None:
    """Simulated agents of equal true means, with episodes that are hard or easy for all; strata of two sections."""
    rng = np.random.default_rng(episodes)
    cases, held = 600, np.zeros(3)
    strata = np.arange(episodes) % 2
    for _ in range(cases):
        sets = []
        for _ in range(2):
            hard = rng.beta(4 * mean, 4 * (1 - mean), episodes)
            sets.append(Scored((rng.random((3, episodes)) < hard).astype(float), strata))
        found = changes(*sets)
        assert found.against_others is not None
        parts = (found.of_each, found.against_others)
        held[:2] += [(part.low[0] <= 0.0 <= part.high[0]) for part in parts]
        held[2] += found.mean.low <= 0.0 <= found.mean.high
    assert np.all((held / cases > 0.925) & (held / cases < 0.99)), held / cases

"""Changes of agents from one epoch of a hidden split to another: what follows from shown means, and by simulation."""

import numpy as np
import pytest

from arramon_server.scoring.disclosure import rounding_step
from arramon_server.scoring.score_changes import EpochScores, score_changes


def test_changes_are_differences_of_the_shown_means() -> None:
    older = EpochScores([0.3, 0.5, 0.4], [1, 1, 2], 1200)
    newer = EpochScores([0.2, 0.5, 0.45], [1, 1, 1], 1000)
    found = score_changes(older, newer)
    assert [one.mean for one in found.of_each] == pytest.approx([-0.1, 0.0, 0.05])
    assert found.mean.mean == pytest.approx(-0.05 / 3, abs=1e-4)
    assert found.against_others is not None
    assert [one.mean for one in found.against_others] == pytest.approx([-0.125, 0.025, 0.1])
    for one in (*found.of_each, *found.against_others, found.mean):
        assert one.low < one.mean < one.high
        assert (one.low * 100, one.high * 100) == pytest.approx((round(one.low * 100), round(one.high * 100)))


def test_an_agent_that_falls_alone_is_found() -> None:
    found = score_changes(EpochScores([0.5, 0.5, 0.5], [1] * 3, 1205), EpochScores([0.5, 0.5, 0.25], [1] * 3, 1205))
    assert found.against_others is not None
    assert found.against_others[2].high < 0.0
    assert [one.low <= 0.0 <= one.high for one in found.against_others[:2]] == [False, False]  # they rose against it
    assert all(one.low <= 0.0 <= one.high for one in found.of_each[:2])


def test_one_agent_has_no_others_and_few_episodes_tell_nothing() -> None:
    found = score_changes(EpochScores([1.0], [1], 5), EpochScores([0.0], [1], 500))
    assert found.against_others is None
    assert (found.mean.mean, found.of_each[0].low, found.of_each[0].high) == (-1.0, -1.0, 1.0)


@pytest.mark.parametrize(("mean", "episodes"), [(0.5, 60), (0.1, 200), (0.9, 300)])
def test_intervals_hold_the_truth_at_least_as_often_as_they_say(mean: float, episodes: int) -> None:
    """Simulated agents of equal true means, with episodes that are hard or easy for all."""
    rng = np.random.default_rng(episodes)
    cases, held = 600, np.zeros(3)
    parts = round(1 / rounding_step(episodes))
    for _ in range(cases):
        sets = []
        for _ in range(2):
            hard = rng.beta(4 * mean, 4 * (1 - mean), episodes)
            scores = (rng.random((3, episodes)) < hard).mean(axis=1)
            shown = np.floor(scores * parts + rng.random(3)) / parts
            sets.append(EpochScores([*shown], [1] * 3, episodes))
        found = score_changes(*sets)
        assert found.against_others is not None
        shown = (found.of_each[0], found.against_others[0], found.mean)
        held += [one.low <= 0.0 <= one.high for one in shown]
    assert np.all(held / cases > 0.95), held / cases

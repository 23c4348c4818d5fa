"""Variance between runs with several seeds, told apart from that between episodes."""

import numpy as np
import pytest

from arramon_server.scoring.seed_spread import seed_spread


def test_components_are_those_of_a_table_computed_by_hand() -> None:
    """Two runs, three episodes; mean squares: runs 0.5/6, episodes 1.75/6, rest 0.25/6."""
    found = seed_spread(np.array([[1.0, 0.5, 0.0], [0.5, 0.5, 0.0]]))
    mean_runs = 3 * np.var([0.5, 1 / 3], ddof=1)
    mean_episodes = 2 * np.var([0.75, 0.5, 0.0], ddof=1)
    rest = np.array([[1.0, 0.5, 0.0], [0.5, 0.5, 0.0]]) - np.array([[0.5], [1 / 3]]) - [0.75, 0.5, 0.0] + 5 / 12
    mean_rest = (rest**2).sum() / 2
    assert found.runs == 2
    assert found.deviation == pytest.approx(max(mean_runs - mean_rest, 0.0) ** 0.5 / 3**0.5)
    assert found.episodes_deviation == pytest.approx(max(mean_episodes - mean_rest, 0.0) ** 0.5 / 2**0.5)
    assert found.rest_deviation == pytest.approx(mean_rest**0.5)
    assert (found.low, found.high) == (0.0, 1.0)  # two runs tell next to nothing of a third


@pytest.mark.parametrize(("runs", "episodes", "rest"), [(0.05, 0.3, 0.2), (0.0, 0.3, 0.2), (0.1, 0.0, 0.1)])
def test_components_are_told_apart(runs: float, episodes: float, rest: float) -> None:
    """Over many made-up tables the estimated variances are on average the true ones."""
    draw, found = np.random.default_rng(0), []
    for _ in range(400):
        scores = 0.5 + runs * draw.normal(size=(5, 1)) + episodes * draw.normal(size=(1, 200))
        spread = seed_spread(scores + rest * draw.normal(size=(5, 200)))
        assert spread.episodes_deviation is not None
        assert spread.rest_deviation is not None
        found.append((spread.deviation**2, spread.episodes_deviation**2, spread.rest_deviation**2))
    of_runs, of_episodes, of_rest = np.mean(found, axis=0)
    assert of_runs == pytest.approx(runs**2, abs=0.0004)
    assert of_episodes == pytest.approx(episodes**2, rel=0.05, abs=0.0005)
    assert of_rest == pytest.approx(rest**2, rel=0.02)


def test_interval_covers_the_mean_over_other_seeds() -> None:
    draw, covered = np.random.default_rng(1), 0
    ability = draw.random(300)
    for _ in range(400):
        shift = 0.06 * draw.normal(size=(4, 1))
        found = seed_spread((draw.random((4, 300)) < np.clip(ability * 0.6 + 0.2 + shift, 0, 1)).astype(float))
        covered += found.low <= float((ability * 0.6 + 0.2).mean()) <= found.high
    assert 0.92 <= covered / 400 <= 0.98


def test_equal_runs_have_no_spread() -> None:
    found = seed_spread(np.tile([0.0, 1.0, 1.0, 0.0], (3, 1)))
    assert (found.deviation, found.rest_deviation, found.low, found.high) == (0.0, 0.0, 0.5, 0.5)
    assert found.episodes_deviation == pytest.approx(np.std([0, 1, 1, 0], ddof=1))

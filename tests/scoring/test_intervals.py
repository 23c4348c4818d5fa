"""Confidence intervals with literal numbers, and against independent implementations."""

import numpy as np
import pytest
import scipy  # which loads scipy.stats when a test asks for it

from arramon_server.scoring.intervals import (
    Floats,
    episode_moments,
    mean_bounds,
    section_bounds,
    section_means,
    section_spread,
)


def bounds(values: list[float], strata: list[int] | None = None) -> tuple[float, float, float]:
    found = mean_bounds(episode_moments(np.array(values), np.array(strata or [0] * len(values))))
    return float(found.mean), float(found.low), float(found.high)


@pytest.mark.parametrize(("hits", "number"), [(0, 100), (1, 100), (30, 100), (600, 1205), (1205, 1205)])
def test_of_single_trials_it_is_wilsons_interval(hits: int, number: int) -> None:
    wilson = scipy.stats.binomtest(hits, number).proportion_ci(method="wilson")
    _, low, high = bounds([1.0] * hits + [0.0] * (number - hits))
    # Student's t in place of the normal distribution makes it a little wider.
    assert (low, high) == pytest.approx((wilson.low, wilson.high), abs=0.002)
    assert low <= wilson.low
    assert high >= wilson.high


def test_of_many_scores_it_is_students_interval() -> None:
    values = np.random.default_rng(0).beta(8, 8, size=400)
    student = scipy.stats.t.interval(0.95, 399, values.mean(), scipy.stats.sem(values))
    assert bounds(values.tolist())[1:] == pytest.approx(student, abs=0.001)


@pytest.mark.parametrize(
    ("values", "low", "high"),
    [
        ([0.5], 0.0, 1.0),  # one episode tells nothing of others
        ([0.0] * 10, 0.0, 0.338),
        ([1.0] * 10, 0.662, 1.0),
        ([0.5] * 10, 0.390, 0.610),  # as if one of eleven episodes had been 0 or 1
        ([0.0, 1.0], 0.003, 0.997),
    ],
)
def test_few_or_equal_scores(values: list[float], low: float, high: float) -> None:
    assert bounds(values)[1:] == pytest.approx((low, high), abs=0.001)


def test_the_variance_is_that_within_strata() -> None:
    values, strata = np.array([0.0, 0.2, 0.8, 1.0, 0.9]), np.array([0, 0, 1, 1, 1])
    moments = episode_moments(values, strata)
    expected = (2 / 5) ** 2 * np.var([0.0, 0.2], ddof=1) / 2 + (3 / 5) ** 2 * np.var([0.8, 1.0, 0.9], ddof=1) / 3
    assert moments.freedom == 3
    assert float(moments.variance) == pytest.approx(expected)


def test_strata_of_one_episode_are_taken_together() -> None:
    alone = episode_moments(np.array([0.0, 1.0, 0.5]), np.array([0, 1, 2]))
    together = episode_moments(np.array([0.0, 1.0, 0.5]), np.array([0, 0, 0]))
    assert alone == together


def made(sections: list[float], number: int) -> tuple[Floats, "np.typing.NDArray[np.intp]"]:
    """Return episodes that alternate by 0.1 around the mean of their section."""
    values = np.concatenate([np.tile([mean - 0.1, mean + 0.1], number // 2) for mean in sections])
    return values, np.repeat(np.arange(len(sections)), number)


def test_other_sections_are_as_uncertain_as_students_interval_says() -> None:
    means = [0.42, 0.5, 0.47, 0.55, 0.52]
    values, sections = made(means, 20)
    found = section_bounds(values, sections)
    assert found is not None
    student = scipy.stats.t.interval(0.95, 4, np.mean(means), scipy.stats.sem(means))
    assert (float(found.low), float(found.high)) == pytest.approx(student, abs=0.003)
    assert section_means(values, sections) == pytest.approx(means)


def test_the_spread_of_sections_is_without_the_error_of_their_episodes() -> None:
    values, sections = made([0.4, 0.6], 20)
    expected = (np.var([0.4, 0.6], ddof=1) - np.var(np.tile([-0.1, 0.1], 10), ddof=1) / 20) ** 0.5
    assert float(section_spread(values, sections) or 0) == pytest.approx(expected)
    values, sections = made([0.5, 0.5], 20)
    assert float(section_spread(values, sections) or 0) == 0.0


def test_one_section_tells_nothing_of_others() -> None:
    values, sections = made([0.5], 20)
    assert section_bounds(values, sections) is None
    assert section_spread(values, sections) is None

"""What is shown of scores on a hidden split: noise, steps, intervals, and that nothing else enters."""

import numpy as np
import pytest

from server.scoring.aggregate import ROWS
from server.scoring.disclosure import LEAST, NOISE, TEST_NOISE, step_of
from server.scoring.episode import GATES, METRICS, PLACEMENT
from server.scoring.masking import (
    P_CLASSES,
    Noise,
    coarse,
    difference,
    masked_rows,
    mean_interval,
    mean_of_rows,
    p_class,
    rounded_rows,
    total_deviation,
)

SECRET = Noise(b"\7" * 32)
SHOWN_ONCE = 0.19181267463022994


def table(episodes: int, mean: float, seed: int = 0) -> np.ndarray:
    """Equal scores in all metrics, 0 or 1, (episodes, 2, METRICS)."""
    draw = np.random.default_rng(seed).random((episodes, 2, 1)) < mean
    return np.repeat(draw.astype(float), len(METRICS), axis=2)


def test_noise_is_standard_normal_and_follows_from_key_and_names() -> None:
    drawn = np.array([SECRET.normal("run", str(number)) for number in range(20_000)])
    assert abs(drawn.mean()) < 0.03
    assert abs(drawn.std() - 1.0) < 0.02
    assert SECRET.normal("a", "b") == SECRET.normal("a", "b")
    assert len({Noise(key).normal(*names) for key in (b"1", b"2") for names in (("a", "b"), ("ab",), ("b", "a"))}) == 6


def test_noise_of_a_fixed_run_never_changes() -> None:
    """Receipts depend on it."""
    assert SECRET.normal("run", "turn 1", "PTC") == pytest.approx(SHOWN_ONCE, abs=1e-12)


def test_noise_in_a_mean_is_that_of_some_episodes() -> None:
    scores = table(60, 0.5)
    exact = scores[:, 0, 0].mean()
    shown = [masked_rows(scores, SECRET, f"run {number}")["turn 1"]["nDTW"].mean for number in range(400)]
    rounding = step_of(60) / 12**0.5
    assert np.std(shown) == pytest.approx(np.hypot(NOISE / 60, rounding), rel=0.15)
    assert np.mean(shown) == pytest.approx(exact, abs=5 * float(np.std(shown)) / 20)


@pytest.mark.parametrize("episodes", [24, 60, 300, 1205])
def test_everything_shown_is_on_the_grid_and_in_order(episodes: int) -> None:
    rows = masked_rows(table(episodes, 0.4), SECRET, "run")
    parts = round(1 / step_of(episodes))
    assert list(rows) == list(ROWS)
    for row, values in rows.items():
        assert list(values) == list(METRICS)
        for value in values.values():
            assert 0.0 <= value.low <= value.mean <= value.high <= 1.0
            for number, by in ((value.mean, 1 + (row == "total")), (value.low, 1), (value.high, 1)):
                assert number * parts * by == pytest.approx(round(number * parts * by), abs=1e-3)
            assert value.sections is None
    for metric in METRICS:
        turns = [rows[row][metric].mean for row in ROWS[:2]]
        assert rows["total"][metric].mean == pytest.approx(sum(turns) / 2, abs=1e-4)
    for values in rows.values():
        assert values["CTC-3"].mean <= values["CTC-5"].mean <= values["CTC-7"].mean
        for gate in GATES:
            assert all(values[f"{name}@{gate}"].mean <= values[name].mean for name in PLACEMENT)
            assert values[f"PTC@{gate}"].mean <= values[f"rPOD@{gate}"].mean


def test_few_episodes_show_nothing_but_noise() -> None:
    """Fewer than LEAST have intervals from 0 to 1, and the noise is larger than what one of them can move."""
    for scores in (np.zeros((LEAST - 1, 2, len(METRICS))), np.ones((LEAST - 1, 2, len(METRICS)))):
        for values in masked_rows(scores, SECRET, "run").values():
            assert {(value.low, value.high) for value in values.values()} == {(0.0, 1.0)}
    assert difference(1.0, 0.0, LEAST - 1, 0.1).low == -1.0


@pytest.mark.parametrize(("episodes", "mean"), [(60, 0.5), (300, 0.05), (1205, 0.3), (1205, 0.99)])
def test_intervals_of_shown_means_hold_the_truth(episodes: int, mean: float) -> None:
    """In simulations with equal scores of both turns, the largest variance that there is: at least in 95%."""
    rng = np.random.default_rng(episodes)
    step, held = step_of(episodes), 0
    for _ in range(1000):
        exact = (rng.random(episodes) < mean).mean()
        shown = np.clip(np.rint((exact + rng.normal(0, NOISE / episodes)) / step) * step, 0, 1)
        value = mean_interval(float(shown), episodes, NOISE / episodes, step)
        held += value.low <= mean <= value.high
    assert held >= 950


@pytest.mark.parametrize(("episodes", "one", "other"), [(60, 0.5, 0.5), (300, 0.1, 0.2), (1205, 0.3, 0.35)])
def test_intervals_of_differences_hold_the_truth(episodes: int, one: float, other: float) -> None:
    """Runs that solve episodes independently of each other, both turns alike."""
    rng = np.random.default_rng(episodes)
    parts, held = 2 * round(1 / step_of(episodes)), 0
    deviation = total_deviation(episodes)
    for _ in range(1000):
        means = [(rng.random(episodes) < mean).mean() + rng.normal(0, deviation) for mean in (one, other)]
        shown = [float(np.clip(np.rint(mean * parts) / parts, 0, 1)) for mean in means]
        value = difference(shown[0], shown[1], episodes, 2**0.5 * deviation)
        held += value.low <= one - other <= value.high
    assert held >= 950


def test_means_over_runs_follow_from_their_shown_rows() -> None:
    tables = [masked_rows(table(300, 0.4, seed), SECRET, str(seed)) for seed in range(3)]
    joined = mean_of_rows(tables, 300)
    for row in ROWS:
        for metric in METRICS:
            found = joined[row][metric]
            assert found.mean == pytest.approx(np.mean([one[row][metric].mean for one in tables]), abs=1e-4)
            assert found.low <= found.mean <= found.high


def test_rows_without_their_truth_are_rounded() -> None:
    rows = masked_rows(table(60, 0.4), SECRET, "run")
    assert rounded_rows(rows, 60)["turn 1"] == rows["turn 1"]


@pytest.mark.parametrize(
    ("p", "bound"), [(0.0, 0.001), (0.001, 0.001), (0.0011, 0.01), (0.049, 0.05), (0.06, 1), (1, 1)]
)
def test_p_values_are_rounded_up(p: float, bound: float) -> None:
    assert p_class(p) == bound
    assert bound in P_CLASSES


@pytest.mark.parametrize(("number", "shown"), [(0, 0), (7, 7), (12_345, 12_000), (0.0123456, 0.012)])
def test_coarse_numbers_have_two_digits(number: float, shown: float) -> None:
    assert coarse(number) == shown


def test_test_scores_sum_to_noise_of_some_episodes() -> None:
    sums = [SECRET.test_scores(str(number), "PTC").sum() for number in range(3000)]
    assert np.std(sums) == pytest.approx(TEST_NOISE, rel=0.05)
    assert abs(np.mean(sums)) < 0.3
    assert len(SECRET.test_scores("run", "PTC")) == LEAST

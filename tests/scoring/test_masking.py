"""What is shown of scores on a hidden split: rounding, steps, intervals, and that nothing else enters."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from arramon_server.scoring.aggregate import ROWS
from arramon_server.scoring.disclosure import MIN_EPISODES, STEPS, TEST_NOISE, rounding_step
from arramon_server.scoring.episode_scores import GATES, METRICS, PLACEMENT
from arramon_server.scoring.masking import (
    P_CLASSES,
    Noise,
    Rows,
    masked_rows,
    masked_share,
    mean_interval,
    mean_of_rows,
    p_value_class,
    randomised_rounding,
    rounded_rows,
    shown_deviation,
    shown_difference,
    two_digits,
)

SECRET = Noise(b"\7" * 32)
SHOWN_ONCE = 0.19181267463022994


def table(episodes: int, mean: float, seed: int = 0) -> np.ndarray:
    """Equal scores in all metrics, 0 or 1, (episodes, 2, METRICS)."""
    draw = np.random.default_rng(seed).random((episodes, 2, 1)) < mean
    return np.repeat(draw.astype(float), len(METRICS), axis=2)


def random_scores(episodes: int, draw: np.random.Generator) -> npt.NDArray[np.float64]:
    """Scores in which all metrics follow from each other as real ones do, (episodes, 2, METRICS)."""
    level, hard = draw.random((episodes, 2)), draw.random()
    values: dict[str, npt.NDArray[np.floating[Any]]]
    values = {"nDTW": draw.random((episodes, 2)), "CTC-0": (draw.random((episodes, 2)) < draw.random()) * 1.0}
    values |= {f"CTC-{k}": (level < hard * k / 7) * 1.0 for k in (3, 5, 7)}
    values["PTC"] = (draw.random((episodes, 2)) < draw.random()) * 1.0
    values["rPOD"] = np.where(values["PTC"] > 0.0, 1.0, draw.random((episodes, 2)) * draw.integers(0, 2))
    values |= {f"{name}@{gate}": values[name] * values[gate] for name in PLACEMENT for gate in GATES}
    return np.stack([values[metric] for metric in METRICS], axis=2)


def test_noise_is_standard_normal_and_follows_from_key_and_names() -> None:
    drawn = np.array([SECRET.normal("run", str(number)) for number in range(20_000)])
    assert abs(drawn.mean()) < 0.03
    assert abs(drawn.std() - 1.0) < 0.02
    assert SECRET.normal("a", "b") == SECRET.normal("a", "b")
    assert len({Noise(key).normal(*names) for key in (b"1", b"2") for names in (("a", "b"), ("ab",), ("b", "a"))}) == 6


def test_noise_of_a_fixed_run_never_changes() -> None:
    """Receipts depend on it."""
    assert SECRET.normal("run", "turn 1", "PTC") == pytest.approx(SHOWN_ONCE, abs=1e-12)


def test_rounding_is_right_on_average_and_never_off_by_a_step() -> None:
    draw = np.random.default_rng(0)
    for step in STEPS:
        for value in draw.random(20):
            shown = np.array([randomised_rounding(value, step, threshold) for threshold in draw.random(4000)])
            assert np.abs(shown - value).max() < step
            if step <= value <= 1.0 - step:
                assert shown.mean() == pytest.approx(value, abs=0.04 * step)


@pytest.mark.parametrize("step", STEPS)
def test_numbers_on_the_grid_are_shown_as_they_are(step: float) -> None:
    """Also where the sum that made them differs in its last bits, as between machines."""
    for part in range(round(1 / step) + 1):
        for value in (part * step, part / round(1 / step), np.nextafter(part * step, 0), np.nextafter(part * step, 2)):
            shown = {randomised_rounding(float(value), step, threshold) for threshold in (1e-15, 0.5, 1 - 1e-15)}
            assert shown == {part / round(1 / step)}


@pytest.mark.parametrize("episodes", [3, 24, 60, 300, 1205])
def test_nothing_shown_is_a_step_from_the_exact_mean(episodes: int) -> None:
    """With the order of the metrics put right."""
    draw = np.random.default_rng(episodes)
    for number in range(40):
        scores = random_scores(episodes, draw)
        rows, exact = masked_rows(scores, SECRET, f"play {number}"), scores.mean(axis=0)
        assert list(rows) == list(ROWS)
        for at, metric in enumerate(METRICS):
            for turn, row in enumerate(ROWS[:2]):
                assert abs(rows[row][metric].mean - exact[turn, at]) < rounding_step(episodes)
            assert abs(rows["total"][metric].mean - exact[:, at].mean()) < rounding_step(episodes)
        check_order(rows)


def test_thresholds_of_metrics_turns_and_plays_are_independent() -> None:
    """As the bound of `figure_bits` for several figures together supposes."""
    scores = table(60, 0.5)
    columns = [METRICS.index(metric) for metric in ("nDTW", "CTC-0", "CTC-7", "rPOD")]
    shown = np.array([
        [rows[row][METRICS[at]].mean for row in ROWS[:2] for at in columns]
        for rows in (masked_rows(scores, SECRET, f"play {number}") for number in range(600))
    ])  # fmt: skip
    assert scores[:, 0, 0].mean() == pytest.approx(scores[:, 1, 0].mean(), abs=0.2)
    together = np.corrcoef(shown.T) - np.eye(shown.shape[1])
    assert np.abs(together).max() < 0.17  # four standard errors
    assert (shown.std(axis=0) > 0).all()


def test_who_scores_nothing_shows_nothing_and_who_scores_all_shows_all() -> None:
    for episodes in (3, 19, 60, 1205):
        for score in (0.0, 1.0):
            rows = masked_rows(np.full((episodes, 2, len(METRICS)), score), SECRET, "play")
            assert {value.mean for values in rows.values() for value in values.values()} == {score}


def test_without_a_play_nothing_is_shown() -> None:
    """All runs would share their thresholds."""
    with pytest.raises(ValueError, match="digest of the play is missing"):
        masked_rows(table(60, 0.4), SECRET, "")
    with pytest.raises(ValueError, match="digest of the play is missing"):
        SECRET.test_scores("", "PTC")


def test_shares_are_rounded_like_rows() -> None:
    shown = {masked_share(0.43, 60, SECRET, ["same outcome", str(number)]) for number in range(100)}
    assert shown == {0.4, 0.5}
    assert masked_share(1.0, 60, SECRET, ["same outcome"]) == 1.0


@pytest.mark.parametrize("episodes", [24, 60, 300, 1205])
def test_everything_shown_is_on_the_grid_and_in_order(episodes: int) -> None:
    rows = masked_rows(table(episodes, 0.4), SECRET, "play")
    parts = round(1 / rounding_step(episodes))
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
    check_order(rows)


def check_order(rows: Rows) -> None:
    for values in rows.values():
        assert values["CTC-3"].mean <= values["CTC-5"].mean <= values["CTC-7"].mean
        for gate in GATES:
            for name in PLACEMENT:
                assert values[f"{name}@{gate}"].mean <= min(values[name].mean, values[gate].mean)
            assert values[f"PTC@{gate}"].mean <= values[f"rPOD@{gate}"].mean


def test_few_episodes_have_no_intervals() -> None:
    """Fewer than MIN_EPISODES have intervals from 0 to 1."""
    for scores in (np.zeros((MIN_EPISODES - 1, 2, len(METRICS))), np.ones((MIN_EPISODES - 1, 2, len(METRICS)))):
        for values in masked_rows(scores, SECRET, "play").values():
            assert {(value.low, value.high) for value in values.values()} == {(0.0, 1.0)}
    assert shown_difference(1.0, 0.0, MIN_EPISODES - 1, 0.1).low == -1.0


@pytest.mark.parametrize("alike", [1, 8])
@pytest.mark.parametrize(("episodes", "mean"), [(60, 0.5), (60, 0.58), (300, 0.05), (1205, 0.308), (1205, 0.99)])
def test_intervals_of_shown_means_hold_the_truth(episodes: int, mean: float, alike: int) -> None:
    """In simulations with equal scores of both turns, the largest variance that there is: at least in 95%.

    Also where the figure is the least one of 8 that are alike, as the order of the metrics wants it.
    """
    rng = np.random.default_rng(episodes)
    step, held = rounding_step(episodes), 0
    for _ in range(1000):
        exact = float((rng.random(episodes) < mean).mean())
        shown = min(randomised_rounding(exact, step, threshold) for threshold in rng.random(alike))
        value = mean_interval(shown, episodes, shown_deviation(episodes), step)
        held += value.low <= mean <= value.high
    assert held >= 950


@pytest.mark.parametrize(("episodes", "one", "other"), [(60, 0.5, 0.5), (300, 0.1, 0.2), (1205, 0.3, 0.35)])
def test_intervals_of_differences_hold_the_truth(episodes: int, one: float, other: float) -> None:
    """Runs that solve episodes independently of each other, both turns alike."""
    rng = np.random.default_rng(episodes)
    step, held = rounding_step(episodes), 0
    for _ in range(1000):
        means = [float((rng.random(episodes) < mean).mean()) for mean in (one, other)]
        shown = [randomised_rounding(mean, step, rng.random()) for mean in means]
        value = shown_difference(shown[0], shown[1], episodes, 2**0.5 * shown_deviation(episodes))
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
    rows = masked_rows(table(60, 0.4), SECRET, "play")
    assert rounded_rows(rows, 60)["turn 1"] == rows["turn 1"]


@pytest.mark.parametrize(
    ("p", "bound"), [(0.0, 0.001), (0.001, 0.001), (0.0011, 0.01), (0.049, 0.05), (0.06, 1), (1, 1)]
)
def test_p_values_are_rounded_up(p: float, bound: float) -> None:
    assert p_value_class(p) == bound
    assert bound in P_CLASSES


@pytest.mark.parametrize(("number", "shown"), [(0, 0), (7, 7), (12_345, 12_000), (0.0123456, 0.012)])
def test_numbers_are_rounded_to_two_digits(number: float, shown: float) -> None:
    assert two_digits(number) == shown


def test_test_scores_sum_to_noise_of_some_episodes() -> None:
    sums = [SECRET.test_scores(str(number), "PTC").sum() for number in range(3000)]
    assert np.std(sums) == pytest.approx(TEST_NOISE, rel=0.05)
    assert abs(np.mean(sums)) < 0.3
    assert len(SECRET.test_scores("run", "PTC")) == MIN_EPISODES

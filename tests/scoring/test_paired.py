"""Paired permutation tests against independent implementations, exact enumeration, and literal numbers."""

from collections.abc import Sequence
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scipy  # which loads scipy.stats when a test asks for it
from sacrebleu.significance import PairedTest

from arramon_server.scoring.intervals import Floats
from arramon_server.scoring.paired import (
    FAR,
    FEW,
    FLIPS,
    difference_bounds,
    holm,
    permutation_tests,
    tail_probabilities,
)


def runs(gap: float, number: int = 60, seed: int = 0) -> Floats:
    """Return scores of two runs that differ by `gap` on average, and agree on what is hard."""
    draw = np.random.default_rng(seed)
    hard = draw.random(number)
    return np.clip(np.stack([hard + gap, hard]) + 0.15 * draw.standard_normal((2, number)), 0.0, 1.0)


@pytest.mark.parametrize("gap", [0.0, 0.02, 0.05, 0.08])
def test_it_agrees_with_scipy(gap: float) -> None:
    scores = runs(gap)
    found = scipy.stats.permutation_test(
        (scores[0], scores[1]), lambda x, y, axis: (x - y).mean(axis=axis), permutation_type="samples",
        n_resamples=20_000, vectorized=True, rng=np.random.default_rng(1),
    )  # fmt: skip
    # Both are random: three standard errors of their difference, and a tenth for the tail.
    error = 3.0 * (found.pvalue * (1.0 / FLIPS + 1.0 / 20_000)) ** 0.5
    assert permutation_tests(scores)[0, 1] == pytest.approx(found.pvalue, abs=error + 1e-4, rel=0.1)


class Mean:
    """A metric for sacrebleu: the mean of scores, each written as a "hypothesis"."""

    def _extract_corpus_statistics(self, hypotheses: Sequence[str], references: object) -> Floats:
        return np.array([[float(text), 1.0] for text in hypotheses])

    def _aggregate_and_compute(self, statistics: Floats) -> SimpleNamespace:
        total, number = np.sum(statistics, axis=0)
        return SimpleNamespace(name="mean", score=total / number)

    def get_signature(self) -> SimpleNamespace:
        return SimpleNamespace(update=lambda name, value: None)


@pytest.mark.parametrize("gap", [0.0, 0.03, 0.06])
def test_it_agrees_with_sacrebleus_approximate_randomisation(gap: float) -> None:
    scores = runs(gap, seed=2)
    systems: Any = [(name, [repr(float(score)) for score in run]) for name, run in zip("ab", scores, strict=True)]
    metrics: Any = {"mean": Mean()}
    test = PairedTest(systems, metrics, None, test_type="ar", n_samples=10_000, n_jobs=1)
    _, found = test()
    result: Any = found["mean"][1]
    p = result.p_value
    assert permutation_tests(scores)[0, 1] == pytest.approx(p, abs=3.0 * (2.0 * p / 10_000) ** 0.5 + 2e-4)


def exact(differences: Floats) -> float:
    """Return the two-sided tail over all signs."""
    signs = np.array(list(product((-1, 1), repeat=len(differences))))
    return float((np.abs(signs @ differences) >= abs(differences.sum()) - 1e-9).mean())


@pytest.mark.parametrize("number", [10, 14, 18])
@pytest.mark.parametrize("kind", ["one size", "halves", "parts", "continuous"])
def test_the_tail_is_that_of_all_signs(kind: str, number: int) -> None:
    draw = np.random.default_rng(number)
    sizes = {
        "one size": np.ones(number),
        "halves": draw.choice([0.5, 1.0], number),
        "parts": draw.choice([1.0, 0.5, 0.2, 0.1], number),
        "continuous": draw.random(number),
    }[kind]
    for wrong in range(3):
        differences = sizes.copy()
        differences[:wrong] *= -1.0
        expected = exact(differences)
        if expected < (FEW + 1) / FLIPS:  # where it is used
            assert tail_probabilities(differences[None])[0] == pytest.approx(expected, rel=0.25)


@pytest.mark.parametrize(("wins", "losses"), [(30, 5), (40, 4), (100, 40), (60, 0), (600, 480)])
def test_of_differences_of_one_size_it_is_the_sign_test(wins: int, losses: int) -> None:
    differences = np.array([1.0] * wins + [-1.0] * losses + [0.0] * 50)
    expected = scipy.stats.binomtest(wins, wins + losses).pvalue
    assert tail_probabilities(differences[None])[0] == pytest.approx(expected, rel=0.05)
    found = permutation_tests(np.stack([differences, np.zeros_like(differences)]))[0, 1]
    if (wins - losses) ** 2 < FAR**2 * (wins + losses):
        assert found == pytest.approx(expected, rel=0.05, abs=3e-4)
    else:
        assert expected <= found < 5e-11


def test_equal_runs_do_not_differ() -> None:
    scores = np.tile(runs(0.0)[0], (3, 1))
    assert permutation_tests(scores).tolist() == np.ones((3, 3)).tolist()
    opposite = np.stack([np.tile([0.0, 1.0], 20), np.tile([1.0, 0.0], 20)])
    assert permutation_tests(opposite)[0, 1] == 1.0


def test_all_pairs_at_once_are_as_each_alone() -> None:
    scores = np.concatenate([runs(0.05), runs(0.1, seed=1)])
    together = permutation_tests(scores)
    assert together.tolist() == together.T.tolist()
    for i in range(4):
        for j in range(i):
            assert together[i, j] == pytest.approx(permutation_tests(scores[[i, j]])[0, 1], abs=2e-3)


@pytest.mark.parametrize(
    ("given", "corrected"),
    [
        ([], []),
        ([0.03], [0.03]),
        ([0.01, 0.04, 0.03], [0.03, 0.06, 0.06]),
        ([0.5, 0.001, 0.9], [1.0, 0.003, 1.0]),
        ([0.02, 0.02], [0.04, 0.04]),
    ],
)
def test_holms_procedure(given: list[float], corrected: list[float]) -> None:
    assert holm(given).tolist() == pytest.approx(corrected)


def test_the_interval_of_a_difference_is_students() -> None:
    first, second = runs(0.05, 400)
    student = scipy.stats.ttest_rel(first, second).confidence_interval(0.95)
    mean, low, high = difference_bounds(first - second, np.zeros(400, np.intp))
    assert mean == pytest.approx((first - second).mean())
    assert (low, high) == pytest.approx((student.low, student.high), abs=0.003)


def test_equal_runs_leave_an_interval() -> None:
    assert difference_bounds(np.zeros(99), np.zeros(99, np.intp)) == pytest.approx((0.0, -0.02, 0.02), abs=1e-4)
    assert difference_bounds(np.array([0.5]), np.zeros(1, np.intp)) == (0.5, -1.0, 1.0)

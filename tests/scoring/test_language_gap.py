"""The gap between languages with literal numbers."""

import numpy as np
import pytest
import scipy  # which loads scipy.stats when a test asks for it

from arramon_server.scoring.language_gap import language_gap


def test_the_gap_of_two_languages_is_paired() -> None:
    draw = np.random.default_rng(0)
    hindi = draw.random(300) * 0.5
    english = hindi + 0.1 + 0.05 * draw.standard_normal(300)
    outcomes = np.zeros((2, 300, 2))
    outcomes[0, :30, 1] = 1.0
    found = language_gap(["en", "hi"], np.stack([english, hindi]), outcomes, np.zeros(300, np.intp))
    student = scipy.stats.ttest_rel(english, hindi).confidence_interval(0.95)
    assert (found.higher, found.lower, found.same, found.episodes) == ("en", "hi", 0.9, 300)
    assert (found.mean, found.low, found.high) == pytest.approx(
        (float((english - hindi).mean()), student.low, student.high), abs=0.004
    )


def test_of_several_languages_the_highest_and_the_lowest() -> None:
    scores = np.array([[0.5, 0.5], [0.2, 0.4], [0.9, 0.9]])
    outcomes = np.array([[[1, 0], [0, 0]], [[1, 0], [0, 0]], [[1, 0], [0, 1]]], dtype=np.float64)
    found = language_gap(["bn", "en", "hi"], scores, outcomes, np.zeros(2, np.intp))
    assert (found.higher, found.lower, found.same) == ("hi", "en", 0.5)
    assert found.mean == pytest.approx(0.6)


def test_equal_languages() -> None:
    found = language_gap(["en", "hi"], np.full((2, 9), 0.5), np.ones((2, 9, 2)), np.zeros(9, np.intp))
    assert (found.higher, found.lower, found.mean, found.same) == ("en", "hi", 0.0, 1.0)
    assert found.low < 0.0 < found.high

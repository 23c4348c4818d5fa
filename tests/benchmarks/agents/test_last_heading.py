"""Differences of headings, as the benchmark of last headings counts them."""

import pytest

from benchmarks.agents.last_heading import difference, shares


@pytest.mark.parametrize(
    ("heading", "other", "degrees"), [(0, 0, 0), (0, 11, 30), (11, 0, 30), (2, 9, 150), (3, 9, 180), (10, 1, 90)]
)
def test_difference_is_the_smaller_angle(heading: int, other: int, degrees: int) -> None:
    assert difference(heading, other) == degrees


def test_shares_add_up_and_large_differences_are_one_column() -> None:
    assert shares([0, 0, 30, 60, 90, 180, 0, 30]) == ["0.38", "0.25", "0.38"]
    assert shares([]) == ["0.00", "0.00", "0.00"]

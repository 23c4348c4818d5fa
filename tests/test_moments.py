"""Moments of faults."""

import pytest

from tests.moments import spread_moments


@pytest.mark.parametrize(("count", "longest"), [(1, 0.05), (7, 1.0), (20, 0.02)])
def test_each_part_of_the_interval_is_hit_once(count: int, longest: float) -> None:
    moments = spread_moments(count, longest, seed=3)
    assert sorted(int(moment * count / longest) for moment in moments) == list(range(count))
    assert moments == spread_moments(count, longest, seed=3)

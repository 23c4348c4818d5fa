"""nDTW of a growing path equals that of the whole path, after every position."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arramon_server.scoring.metrics import ndtw
from arramon_server.scoring.running_ndtw import RunningNdtw

POINT = st.tuples(st.integers(-5, 5).map(float), st.integers(-5, 5).map(float))


@given(st.lists(POINT, min_size=1, max_size=8), st.lists(POINT, max_size=12))
def test_value_equals_the_metric(reference: list[tuple[float, float]], path: list[tuple[float, float]]) -> None:
    running = RunningNdtw(reference)
    assert running.value == 0.0
    for count, point in enumerate(path, start=1):
        running.add(point)
        assert running.value == pytest.approx(ndtw(path[:count], reference), abs=1e-12)


def test_empty_reference_is_refused() -> None:
    with pytest.raises(ValueError, match="reference path is empty"):
        RunningNdtw([])

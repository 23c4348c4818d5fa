"""Agents that wait, in three ways of playing."""

import pytest

from arramon_client import Observation
from benchmarks.serving.waiting import ONE_IN, Delays
from tests.benchmarks.command import numbers, printed


def test_one_call_in_twenty_is_slow() -> None:
    delays = Delays(call=0.1, slow_call=3.0)
    seen = [delays.of(Observation("e", 1, "navigation", step, "", step, 150)) for step in range(4 * ONE_IN)]
    assert (seen.count(3.0), seen.count(0.1)) == (4, 4 * ONE_IN - 4)


@pytest.mark.slow
def test_rates() -> None:
    lines = printed("benchmarks.serving.waiting", "--seconds", 0.5, "--rounds", 1, "--call", 0.01, "--slow-call", 0.02)
    for row in ("free-running", "async agent", "batch agent"):
        rate, ratio = numbers(lines, row)
        assert rate > 0
        assert ratio > 0
    (ideal,) = numbers(lines, "without any other cost")
    assert ideal == pytest.approx(8 * 20 / 0.21, abs=0.1)

"""People on the play page beside agents."""

import pytest

from tests.benchmarks.command import numbers, printed


@pytest.mark.slow
def test_waits_and_rates() -> None:
    options = ("--people", 2, "--size", 64, "--pause", 0.2, "--seconds", 1)
    lines = printed("benchmarks.serving.people", *options)
    p50, p99, rate, _, keys, lost = numbers(lines, "2 people at 64")
    assert 0 < p50 <= p99
    assert rate > 0
    assert keys > 0
    assert lost == 0
    (alone, beside, _) = numbers(lines, "2 agents:")
    assert min(alone, beside) > 0

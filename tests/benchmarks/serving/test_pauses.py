"""Waits of open episodes when a server process ends."""

from pathlib import Path

import pytest

from tests.benchmarks.command import numbers, printed


@pytest.mark.slow
def test_waits(many: Path) -> None:
    lines = printed("benchmarks.serving.pauses", "--data", many, "--rounds", 1, "--parallel", 4, "--seconds", 0.3)
    assert len(lines) == 4
    for row in (
        "one of two workers drains",
        "one of two workers is killed",
        "the only process is killed, and restarted",
    ):
        quiet, median, longest = numbers(lines, row)
        assert quiet > 0
        assert median == longest > 0

"""The growth benchmark, run briefly: loads, bodies and starts."""

from pathlib import Path

import pytest

from tests.benchmarks.command import numbers, printed

MODULE = "benchmarks.serving.growth"


def test_loads_and_bodies(many: Path) -> None:
    arguments = "--data", many, "--seconds", 0.1, "--rounds", 1, "--only", "loads", "--only", "bodies"
    lines = printed(MODULE, *arguments)
    assert lines[0] == "split tiny, 32 episodes"
    rows = ("1 open episodes", "16 open episodes", *(f"16 episodes on {streams} streams" for streams in (1, 2, 4, 16)))
    for row in rows:
        rate, mean, p99, memory = numbers(lines, row)
        assert min(rate, mean, p99) > 0
        assert memory > 50
    assert not [line for line in lines if line.startswith(("128 open", "first start"))]
    assert min(numbers(lines, "5 bodies")) > 0


@pytest.mark.slow
def test_starts(many: Path) -> None:
    lines = printed(MODULE, "--data", many, "--rounds", 1, "--only", "starts")
    for row in ("first start on a machine", "later start"):
        memory, seconds = numbers(lines, row)
        assert memory > 50
        assert seconds > 0

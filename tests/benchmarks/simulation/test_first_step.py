"""CPU time of a new process until its first step."""

from pathlib import Path

from tests.benchmarks.command import numbers, printed


def test_parts_and_imports(many: Path) -> None:
    lines = printed("benchmarks.simulation.first_step", "--data", many, "--rounds", 1)
    assert lines[0].endswith("import   make  reset   step    all")
    *parts, whole = numbers(lines, "this one  ")
    assert abs(sum(parts) - whole) < 0.01
    assert "numba" in lines[2]

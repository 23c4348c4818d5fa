"""Steps per second of a real server, measured briefly."""

import json
from pathlib import Path

from tests.benchmarks.command import numbers, printed


def test_a_row_beside_the_one_in_process(many: Path, tmp_path: Path) -> None:
    file = tmp_path / "rounds.json"
    arguments = "--data", many, "--seconds", 0.2, "--rounds", 1, "--only", "^16 episodes$", "--json", file
    lines = printed("benchmarks.serving.steps", *arguments)
    assert lines[0].startswith("split tiny, 32 episodes.")
    in_process, served = (numbers(lines, row) for row in ("in process", "16 episodes"))
    assert in_process[:2] == [round(in_process[0]), 1.0]
    rate, _, mean, p50, p99, memory, *_ = served
    assert rate > 0
    assert mean > 0
    assert p50 <= p99
    assert memory > 50  # megabytes, of a process that has loaded NumPy
    (measured,) = json.loads(file.read_text())["rounds"]["16 episodes"]
    assert round(measured["rate"]) == rate

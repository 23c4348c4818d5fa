"""Simulations of intervals and tests, with few repeats."""

import json
from pathlib import Path

from tests.benchmarks.command import printed


def test_intervals_and_pairs(tmp_path: Path) -> None:
    file = tmp_path / "tables.json"
    arguments = "--only", "intervals", "--only", "pairs", "--repeats", 4, "--json", file
    lines = printed("benchmarks.leaderboard.interval_coverage", *arguments)
    tables = json.loads(file.read_text())
    assert [len(tables[name]) for name in ("intervals", "pairs")] == [240, 36]
    assert len(lines) == 240 + 36 + 2 + 2  # with headers and empty lines
    shares = [line["these sections"] for line in tables["intervals"]]
    assert all(share in (0.0, 0.25, 0.5, 0.75, 1.0) for share in shares)
    assert sum(shares) / len(shares) > 0.8  # Nominally 0.95.
    assert all(line["claimed"] in (0.0, 1.0) for line in tables["pairs"])

"""Recovery of landmarks with a part of the texts held out."""

import json
from pathlib import Path

from tests.benchmarks.command import numbers, printed


def test_tables(release: Path, tmp_path: Path) -> None:
    file = tmp_path / "counts.json"
    arguments = "--folds", 2, "--seen", 2, "--json", file
    lines = printed("benchmarks.release.landmarks", release / "release.json", *arguments)
    assert "4 episodes" in lines[0]
    assert "all, en" in lines
    counts = json.loads(file.read_text())
    assert set(counts) >= {"held out", "random", "permuted", "before"}
    assert counts["held out"]["turns"] == 8
    assert numbers(lines, "  cone ")[-1] == 4

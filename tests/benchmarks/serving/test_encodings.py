"""Costs of encoding a single frame."""

import json
from pathlib import Path

from tests.benchmarks.command import printed


def test_sizes(tmp_path: Path) -> None:
    file = tmp_path / "rows.json"
    lines = printed("benchmarks.serving.encodings", "--frames", 1, "--rounds", 1, "--json", file)
    assert lines[0].startswith("| image | encoding | encode us | decode us | kB |")
    rows = {(row["image"], row["side"], row["encoding"]): row for row in json.loads(file.read_text())}
    assert len(rows) == len(lines) - 2 == 16
    assert rows["rgb", 224, "raw"]["kilobytes"] == 224 * 224 * 3 / 1000
    assert rows["depth", 128, "raw"]["kilobytes"] == 128 * 128 * 2 / 1000
    assert all(row["kilobytes"] <= rows[image, side, "raw"]["kilobytes"] for (image, side, _), row in rows.items())

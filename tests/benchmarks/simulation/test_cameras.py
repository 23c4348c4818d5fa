"""Frame rates of both cameras, measured briefly."""

import json
from pathlib import Path

import pytest

from tests.benchmarks.command import numbers, printed
from tests.physics import needs_pybullet


@pytest.mark.slow
@needs_pybullet
def test_rates(many: Path, tmp_path: Path) -> None:
    file = tmp_path / "rates.json"
    arguments = "--data", many, "--rounds", 1, "--seconds", 0.01, "--views", 1, "--json", file
    lines = printed("benchmarks.simulation.cameras", *arguments)
    assert lines[0].startswith("tiny, section 1: ")
    for size in (224, 128):
        rate, of_tiny = numbers(lines, f"tiny, {size}, RGB + depth  ")
        assert rate > 0
        assert of_tiny == 1.0
        assert numbers(lines, f"raster, {size}, RGB + depth + segmentation")[0] > 0
    assert lines[-1].startswith("seconds to the fast camera's first frame: compiled anew ")
    assert len(json.loads(file.read_text())["rates"]) == 10

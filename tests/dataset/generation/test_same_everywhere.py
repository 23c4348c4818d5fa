"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "4104ff361dc4036cec88584b7d9c9bb736e436cf69193c5200142058796c7638",
    "digest": "bce77c71d3f3f5cc4e82fb66c33f3d7acd81c7f19ed58d72b4e0ea357abd7c85",
    "places": "22e91df5a804aefec8b65173ed0c5f77f4a07b4a97ad73fef18382dbfdcd7c7a",
    "scores": "9666b762f489bcfd877a4f523c85e07615454acff69f6f8cd7d15309afe3624a",
    "blocked": 253,
}
"""What `tests.wanderer` prints. A change of street plans, phrases or planners changes it: then renew it."""


@pytest.mark.slow
@pytest.mark.parametrize("physics", [pytest.param("pybullet", marks=needs_pybullet), "plane"])
def test_data_and_scores_are_the_same_everywhere(tmp_path: Path, physics: str) -> None:
    command = [sys.executable, "-m", "tests.wanderer", str(tmp_path), physics]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"pybullet": physics == "pybullet", **EXPECTED}

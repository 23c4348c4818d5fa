"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "65b1f1f138f10c4e51788caa108045ba357ed1b61f124765de59dfbccdc13983",
    "digest": "6f47791e11067a62e27ce90db6053ab4157c513d15d3c275e35856ccc117cda1",
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

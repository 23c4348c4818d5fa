"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "d9ec2147c1aaeebae9f92908e8e892e6322eac5fed18f48f73d65bc2cfb07dfa",
    "digest": "9ea1e2a4a8b4d632cb31d746cb2f91008f5cf2c5675dcb2f9808af083e4001a0",
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

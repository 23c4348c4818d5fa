"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "52a05ed185894d03680810ffa25a32dc70d6841a4343db6af0b483000167836b",
    "digest": "17e9e28d458aa7a9882de13d0870b96c210651a68005274eefd7e8e4ef7ef08c",
    "places": "22e91df5a804aefec8b65173ed0c5f77f4a07b4a97ad73fef18382dbfdcd7c7a",
    "scores": "9666b762f489bcfd877a4f523c85e07615454acff69f6f8cd7d15309afe3624a",
    "blocked": 253,
}
"""What `tests.wanderer` prints. A change of street plans, phrases or planners changes it: then renew it."""


@pytest.mark.parametrize("physics", [pytest.param("pybullet", marks=needs_pybullet), "plane"])
def test_data_and_scores_are_the_same_everywhere(tmp_path: Path, physics: str) -> None:
    command = [sys.executable, "-m", "tests.wanderer", str(tmp_path), physics]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"pybullet": physics == "pybullet", **EXPECTED}

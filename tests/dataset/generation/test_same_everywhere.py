"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "6f448d039092b3b40d3fe1a6549f6d364ed7823b5fdc7f77b3303758eff70880",
    "digest": "ada5aa6a16ac94f89dccfb803eaae203ee5c0d226e21a52d5c632e95f1547620",
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

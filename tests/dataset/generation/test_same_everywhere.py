"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "80f0b95c8ca7264412776c4d78b8b85a5685228a2c62bf65cd0df50bbc703180",
    "digest": "68de508486861beb12781f3528a8e2ceb4a6b557c9e1966adfb59c4e1c28c7ee",
    "places": "46f3a8a151f6ead5c26cf9942d7c2477c29a103f373e2fb6e158c5fe98d5f032",
    "scores": "1742c6f2188af53aed3302c584fafbe712706d9627b13a70130493e1e4adecd2",
    "blocked": 243,
}
"""What `tests.wanderer` prints. A change of street plans, phrases or planners changes it: then renew it."""


@pytest.mark.slow
@pytest.mark.parametrize("physics", [pytest.param("pybullet", marks=needs_pybullet), "plane"])
def test_data_and_scores_are_the_same_everywhere(tmp_path: Path, physics: str) -> None:
    command = [sys.executable, "-m", "tests.wanderer", str(tmp_path), physics]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"pybullet": physics == "pybullet", **EXPECTED}

"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "c4ffcbd2c76cc4c1acb2275a07fca669499c852580970b4320d0a651c0b4146f",
    "digest": "f4d8055493a60be8ab2f02b06bc09334e15661881a3266156438c7fe034a3255",
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

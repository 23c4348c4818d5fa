"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "58fbbf01e7006829bc1fc436beb1c57d61850ba6ba2fdd14336cfaea7a5cc88d",
    "digest": "5dcab4bff01092fa5231ef01acfa82c166d2fd27b4d26a224afec780db50811a",
    "places": "0dd86a4c9c8d9c6864948d157ed80e2edb60f7e288544f03fc39aa61842a2e42",
    "scores": "a2f5c90969fd148e062890e2541557d5c99e84927e3a95876e6c8d7fb8a6262d",
    "blocked": 264,
}
"""What `tests.wanderer` prints. A change of street plans, phrases or planners changes it: then renew it."""


@pytest.mark.slow
@pytest.mark.parametrize("physics", [pytest.param("pybullet", marks=needs_pybullet), "plane"])
def test_data_and_scores_are_the_same_everywhere(tmp_path: Path, physics: str) -> None:
    command = [sys.executable, "-m", "tests.wanderer", str(tmp_path), physics]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"pybullet": physics == "pybullet", **EXPECTED}

"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "bb8932bf59ccf844114422134dee0598e2d8281a16a1c1f6e44e1ed45c462440",
    "digest": "b99ff2c1e33669674f4074e25dbd5bf61d11833cbf211cec87c706d06fc830ec",
    "places": "01dff54dfe6422086845db7833f593ac563dc86b07d47beaaea911b585dfdf99",
    "scores": "c92f808b3a392b5a5c1d14052a58c8cc7003fe3b33c9002982fdfa132429da73",
    "blocked": 270,
}
"""What `tests.wanderer` prints. A change of street plans, phrases or planners changes it: then renew it."""


@pytest.mark.slow
@pytest.mark.parametrize("physics", [pytest.param("pybullet", marks=needs_pybullet), "plane"])
def test_data_and_scores_are_the_same_everywhere(tmp_path: Path, physics: str) -> None:
    command = [sys.executable, "-m", "tests.wanderer", str(tmp_path), physics]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"pybullet": physics == "pybullet", **EXPECTED}

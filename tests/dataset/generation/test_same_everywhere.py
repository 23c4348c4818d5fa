"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "1e736be0e00c346ba1b258958d4be2c22b9f8addb4139c788e298fe12d6c03ac",
    "digest": "60d2418f17df145476c2e026f0eee0b843f27d81147ac0de82cbfc83140ffd6d",
    "places": "83c326623a78fa852639869268aeeb686ac2a66e2afe2207b55bf868fde47a94",
    "scores": "d0d948321895bc1821bfa1b6b1dd3a22eebc90af3f2c06a4c9fc1515a6a5ef10",
    "blocked": 264,
}
"""What `tests.wanderer` prints. A change of street plans, phrases or planners changes it: then renew it."""


@pytest.mark.parametrize("physics", [pytest.param("pybullet", marks=needs_pybullet), "plane"])
def test_data_and_scores_are_the_same_everywhere(tmp_path: Path, physics: str) -> None:
    command = [sys.executable, "-m", "tests.wanderer", str(tmp_path), physics]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"pybullet": physics == "pybullet", **EXPECTED}

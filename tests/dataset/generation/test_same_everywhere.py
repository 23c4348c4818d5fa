"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "3c82446e3f197f4aa9a6e6d2bc75dfc1600714682daea2fcf65556b61eb16a2a",
    "digest": "470688954a2828784d0edb93d46578a145eea2962398f969d84826c9d88a8d6e",
    "places": "e2d9a347c101672cd643747265aa33bec1a5bf66c721428550a3d28cdaa74d5d",
    "scores": "67de74b4ccc7ea90a4c17bea98b45229f4e0f692fc8c85f37a8d93cde83acb83",
    "blocked": 254,
}
"""What `tests.wanderer` prints. A change of street plans, phrases or planners changes it: then renew it."""


@pytest.mark.parametrize("physics", [pytest.param("pybullet", marks=needs_pybullet), "plane"])
def test_data_and_scores_are_the_same_everywhere(tmp_path: Path, physics: str) -> None:
    command = [sys.executable, "-m", "tests.wanderer", str(tmp_path), physics]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"pybullet": physics == "pybullet", **EXPECTED}

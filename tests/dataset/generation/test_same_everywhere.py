"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "8bc87c088bae260a97f83df64a219cd2457c49773fe4cff93a5cb49915785afd",
    "digest": "70b1991abb94cece3c94b6efe79502fbd799c20aa91b663d033f0ad94a0fcce8",
    "places": "2a955daaf43761b61b945e55dd1d74165435349ead93b236a7e5919ab3a08bf9",
    "scores": "c6158498176fbd0124cab84d57ad3b9f3907331f12b6df1e4743196f6fc9c22a",
    "blocked": 253,
}
"""What `tests.wanderer` prints. A change of street plans, phrases or planners changes it: then renew it."""


@pytest.mark.parametrize("physics", [pytest.param("pybullet", marks=needs_pybullet), "plane"])
def test_data_and_scores_are_the_same_everywhere(tmp_path: Path, physics: str) -> None:
    command = [sys.executable, "-m", "tests.wanderer", str(tmp_path), physics]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"pybullet": physics == "pybullet", **EXPECTED}

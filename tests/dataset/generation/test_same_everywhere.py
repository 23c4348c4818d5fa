"""Generated data and scores are the same with every Python, and with and without pybullet."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import needs_pybullet

EXPECTED = {
    "data": "eca25cdc27fa54b2b5826573369c254db63d928cd7c916d4a28f0fa7c4506fab",
    "digest": "39ab336e561cf2b46468aa088bfd4890aba5d524dc02bee030fab348cb3c3165",
    "places": "8bbcb8d645b7fcdf7507bca44d60ac3d76789bab4d5fba404fa91b9deb13994c",
    "scores": "abbb24e5cb9e4ac4ff3f594bed4b323316cd3a36e6773c0bf8dc949586845f60",
    "blocked": 253,
}
"""What `tests.wanderer` prints. A change of street plans, phrases or planners changes it: then renew it."""


@pytest.mark.parametrize("physics", [pytest.param("pybullet", marks=needs_pybullet), "plane"])
def test_data_and_scores_are_the_same_everywhere(tmp_path: Path, physics: str) -> None:
    command = [sys.executable, "-m", "tests.wanderer", str(tmp_path), physics]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"pybullet": physics == "pybullet", **EXPECTED}

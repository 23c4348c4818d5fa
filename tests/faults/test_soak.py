"""A short run of the soak test."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.postgres import binaries

SOAK = ROOT / "benchmarks" / "soak.py"


@pytest.mark.slow
@pytest.mark.parametrize(("database", "workers"), [("sqlite", "2"), ("postgresql", "1")])
def test_short_soak_with_two_kills_has_no_mismatches(database: str, workers: str, tmp_path: Path) -> None:
    if database == "postgresql":
        binaries()
    command = [sys.executable, str(SOAK), "--kills", "2", "--clients", "2", "--minutes", "2", "--patience", "300"]
    command += ["--database", database, "--workers", workers, "--json", str(tmp_path / "figures")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    figures = json.loads((tmp_path / "figures").read_text())
    assert figures["faults"]["server killed"] == 2
    assert figures["runs"] >= 2
    assert figures["mismatches"] == 0

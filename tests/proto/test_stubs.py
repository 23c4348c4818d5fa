"""Committed gRPC stubs: equal to newly generated ones."""

import subprocess
from pathlib import Path

from tests import ROOT


def test_committed_stubs_match_the_protocol_files(tmp_path: Path) -> None:
    subprocess.run([ROOT / "scripts" / "protos", tmp_path], check=True, capture_output=True, text=True)
    made = {path.name: path.read_text() for path in (tmp_path / "arramon" / "v1").iterdir()}
    kept = {path.name: path.read_text() for path in (ROOT / "proto" / "arramon" / "v1").glob("*_pb2*")}
    assert made == kept
    assert len(made) == 12

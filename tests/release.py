"""Location of the official release, for tests that need it; it is never part of this repository."""

import os
from pathlib import Path

import pytest

from tests import ROOT

FOLDER = Path(os.environ.get("ARRAMON_RELEASE", ROOT / "shared" / "release"))

VAL_SEEN = FOLDER / "val_seen.json"

needs_release = pytest.mark.skipif(
    not VAL_SEEN.is_file(),
    reason=f"the official release's val_seen.json is not in {FOLDER}; name its folder in ARRAMON_RELEASE",
)

"""The table in `docs/explanation/faults.md`: every test that it names exists."""

import re

from tests import ROOT


def test_faults_table_names_existing_tests() -> None:
    named = re.findall(r"`([\w/]+\.py)(?:::(\w+))?`", (ROOT / "docs" / "explanation" / "faults.md").read_text())
    assert len(named) > 20
    for path, name in named:
        if path.startswith("benchmarks/"):
            continue
        text = (ROOT / "tests" / path).read_text()
        assert f"def {name or 'test_'}" in text, f"{path}::{name}"

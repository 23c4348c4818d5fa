"""The table of faults names tests that there are."""

import re

from tests import ROOT


def test_every_test_that_the_table_names_is_there() -> None:
    named = re.findall(r"`([\w/]+\.py)(?:::(\w+))?`", (ROOT / "docs" / "faults.md").read_text())
    assert len(named) > 20
    for path, name in named:
        if path.startswith("benchmarks/"):
            continue
        text = (ROOT / "tests" / path).read_text()
        assert f"def {name or 'test_'}" in text, f"{path}::{name}"

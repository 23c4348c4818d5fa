"""The follower's scores with and without a route, in one episode."""

from pathlib import Path

import pytest

from arramon_dataset.release.importer import import_release
from benchmarks.common import SAMPLE
from tests.benchmarks.command import numbers, printed


def test_scores(tmp_path: Path) -> None:
    import_release([SAMPLE], tmp_path)
    lines = printed("benchmarks.instructions.guessing", tmp_path, "--split", "sample", "--episodes", 1)
    for row in ("full text", "target's name alone", "another episode's text"):
        turns, *scores = numbers(lines, row)
        assert turns == 2
        assert len(scores) == 2
        assert all(0.0 <= score <= 1.0 for score in scores)
    assert numbers(lines, "full text")[1:] == pytest.approx(numbers(lines, "another episode's text")[1:])

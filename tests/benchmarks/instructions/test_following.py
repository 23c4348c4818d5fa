"""The follower's scores on the first texts of one episode."""

import json
from pathlib import Path

from tests.benchmarks.command import numbers, printed


def test_scores(tmp_path: Path) -> None:
    file = tmp_path / "scores.json"
    lines = printed("benchmarks.instructions.following", "--episodes", 1, "--json", file)
    assert lines[0].startswith("1 episodes of val_unseen; ")
    for language in ("en", "hi"):
        for row in ("turn 1", "turn 2", "total"):
            scores = numbers(lines, f"{language} {row}")
            assert len(scores) == 9
            assert all(0.0 <= score <= 1.0 for score in scores)
    assert json.loads(file.read_text())["episodes"] == 1

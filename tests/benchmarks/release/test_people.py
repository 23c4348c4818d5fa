"""The follower in the reconstructed city, in one episode, and resuming."""

import json
from pathlib import Path

from tests.benchmarks.command import numbers, printed

MODULE = "benchmarks.release.people"


def test_scores(release: Path, tmp_path: Path) -> None:
    played, file = tmp_path / "played", tmp_path / "rows.json"
    arguments = release, "--split", "release", "--episodes", 1, "--played", played, "--json", file
    lines = printed(MODULE, *arguments)
    for city in ("rebuilt", "before"):
        for text in ("own text", "another's text"):
            turns, *scores = numbers(lines, f"{city}, all turns, {text}")
            assert turns == 2
            assert all(0.0 <= score <= 1.0 for score in scores)
    before = played.read_text()
    rows = json.loads(file.read_text())["rows"]
    assert printed(MODULE, *arguments) == lines
    assert (played.read_text(), json.loads(file.read_text())["rows"]) == (before, rows)

"""Standings of a few made-up runs."""

from pathlib import Path

from tests.benchmarks.command import numbers, printed


def test_times_and_sizes(tmp_path: Path) -> None:
    arguments = "--runs", 3, "--episodes", 12, "--keep", tmp_path
    lines = printed("benchmarks.leaderboard.standings", *arguments)
    assert "4 standings, ranks 1 to" in "\n".join(lines)
    for row in ("first look  ", "first look by nDTW", "next look", "after one more publication", "first look, two"):
        assert len(numbers(lines, row)) == 2
    for row in ("en standings  ", "hi standings  ", "en against", "hi against", "en standings, two languages"):
        assert numbers(lines, row)[0] > 1
    assert (tmp_path / "journal.db").stat().st_size > 0

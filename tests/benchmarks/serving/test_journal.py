"""Duration of journal commits and reads."""

from pathlib import Path

from tests.benchmarks.command import numbers, printed

MODULE = "benchmarks.serving.journal"
QUICK = "--commits", 1, "--rounds", 1


def test_sqlite(tmp_path: Path) -> None:
    lines = printed(MODULE, *QUICK, "--folder", tmp_path)
    assert lines[0].split() == ["ms", "1", "steps", "16", "steps", "128", "steps", "a", "read"]
    for row in ("SQLite  ", "SQLite, no fsync"):
        assert len(numbers(lines, row)) == 4
        assert min(numbers(lines, row)) > 0
    assert not list(tmp_path.iterdir())


def test_postgresql(postgres_url: str, tmp_path: Path) -> None:
    lines = printed(MODULE, *QUICK, "--folder", tmp_path, "--postgres", postgres_url)
    assert min(numbers(lines, "PostgreSQL, no fsync")) > 0

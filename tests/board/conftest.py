"""Fixtures of the leaderboard's tests."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from tests.board.leaderboard_backend import LeaderboardBackend


@pytest.fixture
def backend(tmp_path: Path, database_url: str) -> Iterator[LeaderboardBackend]:
    """A backend with each kind of database."""
    made = LeaderboardBackend(tmp_path, database_url)
    with closing(made.database):
        yield made

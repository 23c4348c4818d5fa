"""Fixtures of the leaderboard's tests."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from tests.board.made import House


@pytest.fixture
def house(tmp_path: Path, database_url: str) -> Iterator[House]:
    """A house with each kind of database."""
    made = House(tmp_path, database_url)
    with closing(made.database):
        yield made

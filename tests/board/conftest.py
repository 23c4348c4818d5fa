"""Fixtures of the leaderboard's tests."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from tests.board.made import House


@pytest.fixture
def house(tmp_path: Path) -> Iterator[House]:
    made = House(tmp_path)
    with closing(made.database):
        yield made

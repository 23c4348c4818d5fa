"""Fixture of the tests of collections."""

from collections.abc import Iterator
from contextlib import closing

import pytest

from arramon_server.runs.storage.database import Database
from tests.collecting.collecting import Field


@pytest.fixture
def field(database_url: str) -> Iterator[Field]:
    """A collection on each kind of database."""
    made = Field(Database(database_url))
    with closing(made.database):
        yield made

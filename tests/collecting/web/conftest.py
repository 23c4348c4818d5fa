"""Fixture: the pages of one collection on a free loopback port, and a browser without scripts."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from tests.collecting.web.site import CollectingSite


@pytest.fixture
def site(tmp_path: Path) -> Iterator[CollectingSite]:
    made = CollectingSite(tmp_path)
    with closing(made):
        yield made

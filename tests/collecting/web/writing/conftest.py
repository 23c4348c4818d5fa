"""A server for all tests of the write page."""

from collections.abc import Iterator
from contextlib import closing

import pytest

from tests.collecting.web.writing.write_site import WriteSite
from tests.web.conftest import browser

__all__ = ["browser", "site"]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WriteSite]:
    site = WriteSite(tmp_path_factory.mktemp("data"))
    with closing(site.database):
        yield site
    assert site.stop() == 0

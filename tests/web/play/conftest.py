"""A server with pages for all tests of the play page."""

from collections.abc import Iterator

import pytest

from tests.web.play.page_client import PageServer


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageServer]:
    server = PageServer(tmp_path_factory.mktemp("data"), "--play-landing-diagram", "--play-compass", "--steps", "20")
    yield server
    assert server.stop() == 0

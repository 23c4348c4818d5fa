"""A house with a site for each test, and a browser for all of them."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from playwright.sync_api import Browser, sync_playwright

from tests.programs import program
from tests.web.made import WebHouse


@pytest.fixture
def web(tmp_path: Path) -> Iterator[WebHouse]:
    made = WebHouse(tmp_path)
    with closing(made.database), closing(made.site):
        yield made


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    chromium = program("chromium", "chromium")
    with sync_playwright() as playwright:
        # Its own sandbox needs privileges that containers and root do not have; the pages are this project's own.
        launched = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield launched
        launched.close()

"""Fixtures of the web tests: a shared site, a new site for tests that change it, and a browser."""

import shutil
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, expect, sync_playwright

from tests.programs import program
from tests.web.leaderboard_site import LeaderboardSite

PATIENCE = 120_000.0
"""Milliseconds after which a page counts as broken, however slow and busy the machine is."""

expect.set_options(timeout=PATIENCE)


@contextmanager
def house_in(folder: Path) -> Iterator[LeaderboardSite]:
    made = LeaderboardSite(folder)
    with closing(made.database):
        try:
            yield made
        finally:
            made.site.close()  # the present one: a test may have started another


@pytest.fixture
def web(tmp_path: Path) -> Iterator[LeaderboardSite]:
    with house_in(tmp_path) as made:
        yield made


@pytest.fixture(scope="session")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LeaderboardSite]:
    """With runs on all splits and in both languages, one not published and one withdrawn: only to look at."""
    with house_in(tmp_path_factory.mktemp("backend")) as made:
        made.fill()
        yield made


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Ends with its module: while it runs, nothing else can run an event loop in this thread."""
    installed = (shutil.which(name) for name in ("chromium", "chromium-browser", "google-chrome"))
    chromium = next((path for path in installed if path), None) or program("chromium", "chromium")
    with sync_playwright() as playwright:
        # Its own sandbox needs privileges that containers and root do not have; the pages are this project's own.
        launched = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        new_context = launched.new_context

        def patient_context(**settings: Any) -> BrowserContext:
            context = new_context(**settings)
            context.set_default_timeout(PATIENCE)
            return context

        launched.new_context = patient_context  # type: ignore[method-assign]
        yield launched
        launched.close()

"""Axe finds nothing serious on any page of workers and hosts, in any language, window and colours."""

import asyncio
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib import resources
from itertools import product
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from arramon_collecting.storage.people.records import Worker
from tests.collecting.web.verify_site import VerifySite, browsers, verify_site
from tests.collecting.web.verifying.test_verify_in_browser import drawn, window
from tests.web.conftest import browser

__all__ = ["browser"]

SERIOUS = ("serious", "critical")

WIDE, NARROW = {"width": 1440, "height": 900}, {"width": 360, "height": 740}

LANGUAGES = ("en", "hi")

LOOKS: tuple[tuple[dict[str, int], Any], ...] = tuple(product((WIDE, NARROW), ("light", "dark")))
"""Windows and colours in which each page is checked, without loading it anew."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[VerifySite]:
    with verify_site(tmp_path_factory.mktemp("data")) as site:
        yield site


def serious_findings(page: Page) -> list[str]:
    """Axe's serious and critical findings on a page, with the elements at fault."""
    package = pytest.importorskip("axe_playwright_python", reason="pip install axe-playwright-python brings axe-core")
    if not page.evaluate("'axe' in window"):
        page.evaluate((resources.files(package) / "axe.min.js").read_text("utf-8"))
    found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")
    return [
        f"{one['id']}: {node['html'][:120]}"
        for one in found["violations"]
        if one["impact"] in SERIOUS
        for node in one["nodes"]
    ]


def check(page: Page, site: VerifySite, paths: dict[str, str]) -> None:
    """Check the pages at the paths, each once a thing of a selector is shown."""
    findings: dict[tuple[Any, ...], list[str]] = {}
    for language, (path, shown) in product(LANGUAGES, paths.items()):
        page.goto(f"{site.pages.replace('/en/', f'/{language}/')}{path}")
        expect(page.locator(shown).first).to_be_visible()
        findings |= {(language, path, *look): found for look, found in in_all_looks(page)}
    assert {where: found for where, found in findings.items() if found} == {}


def in_all_looks(page: Page) -> Iterator[tuple[tuple[int, str], list[str]]]:
    """Yield the findings on a page as it is, by width and colours."""
    for size, scheme in LOOKS:
        page.set_viewport_size(size)  # type: ignore[arg-type]
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")  # Colours change at once.
        yield (size["width"], scheme), serious_findings(page)


def all_findings(page: Page) -> list[str]:
    return [finding for _, found in in_all_looks(page) for finding in found]


def newcomer(site: VerifySite) -> Worker:
    worker, _ = site.store.workers.invite(site.collection)
    return worker


def test_pages_before_the_first_task(browser: Browser, site: VerifySite) -> None:
    with window(browser, site, newcomer(site)) as page:
        check(page, site, {"/": "h1"})
    screenings = {"/screening/write": "form", "/screening/verify": "form"}
    with window(browser, site, site.worker(ready=False)) as page:
        check(page, site, {"/device": "#touch", **screenings, "/placement": "#begin button"})


def test_pages_of_a_worker(browser: Browser, site: VerifySite) -> None:
    author, reader = site.worker(), site.worker()
    site.text(author, "1")
    task = site.store.tasks.claim_write(site.collection, author, ["2"])
    follows = site.store.tasks.claim_verify(site.collection, reader, ())
    assert task is not None
    assert follows is not None
    with window(browser, site, author) as page:
        check(page, site, {"/?notice=sent": "h1", "/forget": "h1", f"/write/{task.task_id}": "#preview img"})
        page.locator("#guidelines summary").click()
        page.locator("#text").fill("आगे 10 बार जाएँ")
        expect(page.locator("#findings li").first).to_be_visible()
        assert all_findings(page) == []
    with window(browser, site, reader) as page:
        check(page, site, {f"/verify/{follows.task_id}": "#game", "/": "h1"})
        page.goto(f"{site.pages}/verify/{follows.task_id}")
        drawn(page, 0)
        page.on("dialog", lambda dialog: dialog.accept())
        page.locator("#give-up").click()
        expect(page.locator("#done")).to_be_visible()
        assert all_findings(page) == []
        with page.expect_response("**/flags"):
            page.locator("#flags input[type=checkbox]").first.check()
        page.locator("#hand-in button").click()
        expect(page.locator("form[action$=take] button")).to_be_visible()
        assert all_findings(page) == []


def test_pages_of_hosts(browser: Browser, site: VerifySite) -> None:
    walked = site.text(site.worker(), "3", evidence={"pastes": 2})

    async def play() -> None:
        async with browsers(site, site.worker()) as (person,):
            path = person.claim()
            await person.follow(path)
            await person.post(f"{path}/hand-in", **{"flag-1-navigation-unclear": "on"})

    with ThreadPoolExecutor(1) as thread:  # Chromium has this one's event loop.
        thread.submit(asyncio.run, play()).result()
    text = f"/review/{walked.text_id}"
    with window(browser, site, site.host) as page:
        pages = (
            "/host",
            "/review",
            text,
            f"{text}/walks/described",
            "/workers",
            f"/workers/{walked.worker_id}",
            "/ledger",
        )
        check(page, site, dict.fromkeys(pages, "h1"))

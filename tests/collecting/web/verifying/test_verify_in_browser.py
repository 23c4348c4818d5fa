"""Verifying in Chromium: the device, the placement test, a text with flags; hosts' pages in both languages."""

import asyncio
import re
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import pytest
from playwright.sync_api import Browser, Dialog, Page, Route, expect

from arramon_collecting.storage.people.records import Worker
from arramon_collecting.web.access import cookie_name
from arramon_server.web.play.practice_split import practice_split
from tests import tiny
from tests.collecting.web.verify_site import NAME, TEXTS, VerifySite, browsers, verify_site
from tests.web.conftest import browser
from tests.web.play.test_play_in_browser import KEYS
from tests.web.test_browser import CONTRASTS, PHONE

__all__ = ["browser"]

LAST = list(practice_split().episodes.values())[-1]

FAILURE = {"turn": 1, "phase": "navigation", "check": "few_words", "severity": "suspicious", "message": "few words"}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[VerifySite]:
    with verify_site(tmp_path_factory.mktemp("data")) as site:
        yield site


@contextmanager
def window(browser: Browser, site: VerifySite, person: Worker, **settings: Any) -> Iterator[Page]:
    """A window in which a person is signed in. Nothing may go wrong in it."""
    context = browser.new_context(**settings)
    cookie = site.store.sign_ins.open(person.worker_id)
    context.add_cookies([{"name": cookie_name(NAME), "value": cookie, "url": site.site}])
    problems: list[str] = []
    context.on("console", lambda message: problems.append(message.text))
    context.on("weberror", lambda error: problems.append(str(error.error)))
    yield context.new_page()
    context.close()
    assert problems == []


def drawn(page: Page, step: int) -> None:
    expect(page.locator("html")).to_have_attribute("data-drawn", re.compile(rf" {step}$"))


def press(page: Page, actions: Any, first: int = 0) -> None:
    """Press the key of each action, and wait for its frame."""
    for step, action in enumerate(actions, start=first):
        page.keyboard.press(KEYS[action])
        drawn(page, step + 1)


def test_a_text_is_followed_flagged_and_handed_in(browser: Browser, site: VerifySite) -> None:
    site.text(site.worker(), "1")
    worker = site.worker()
    task = site.store.tasks.claim_verify(site.collection, worker, ())
    assert task is not None
    with window(browser, site, worker) as page:
        page.goto(f"{site.pages}/verify/{task.task_id}")
        drawn(page, 0)
        expect(page.locator("#instruction")).to_have_text(TEXTS[0][0])
        expect(page.locator("#instruction")).to_have_attribute("lang", "hi")
        expect(page.locator("fieldset:visible")).to_have_count(1)
        with page.expect_response("**/flags"):
            page.get_by_role("checkbox", name="ungrammatical").check()
        expect(page.locator("#frame")).to_be_focused()  # the keys are the game's, and the space bar clears no box
        page.locator(".tips summary").click()
        expect(page.locator(".tips")).to_have_attribute("open", "")
        expect(page.locator("#frame")).to_be_focused()
        expect(page.locator("#progress")).to_be_hidden()  # there is one text
        expect(page.locator("#flags-later")).to_be_visible()
        expect(page.get_by_role("button", name="Give this task back")).to_be_visible()
        press(page, tiny.ACTIONS[:3])
        expect(page.locator("#outcome")).to_contain_text("You picked up an object. Whether it is the right one")
        expect(page.locator("#carried")).to_have_text("an object")
        expect(page.locator("fieldset:visible legend")).to_have_text("Object 1: the place")
        expect(page.locator("#landing")).to_be_visible()
        expect(page.get_by_role("checkbox", name="ungrammatical")).not_to_be_checked()  # of the other text
        page.reload()
        drawn(page, 3)
        page.locator("#frame").focus()
        press(page, tiny.ACTIONS[3:-1], first=3)
        page.keyboard.press(KEYS[tiny.P])
        expect(page.locator("#done")).to_be_focused()
        expect(page.locator("fieldset:visible")).to_have_count(4)
        expect(page.locator("#flags-later")).to_be_hidden()
        expect(page.get_by_role("button", name="Give this task back")).to_be_hidden()  # all is done
        expect(page.locator("svg.map")).to_have_count(0)  # neither maps nor scores
        with page.expect_response("**/flags"):
            page.locator('[name="flag-2-assembly-wrong"]').check()
        page.get_by_role("button", name="Hand in").click()
        expect(page.locator("h1")).to_have_text("Handed in. Thank you.")
    assert site.store.verifications.get(task.task_id).flags == ("1-navigation-ungrammatical", "2-assembly-wrong")


def test_the_placement_test_is_repeated_and_passed(browser: Browser, site: VerifySite) -> None:
    worker = site.worker(ready=False)
    with window(browser, site, worker) as page:
        page.goto(f"{site.pages}/placement?repeat")
        page.get_by_role("button", name="Begin").click()
        drawn(page, 0)
        page.on("dialog", lambda dialog: dialog.accept())
        page.get_by_role("button", name="Skip this part").click()
        expect(page.locator("#status")).to_contain_text("not passed")
        page.get_by_role("link", name="Try the test again").click()
        page.get_by_role("button", name="Begin").click()
        actions = [action for turn in LAST.turns for action in (*turn.actions, *turn.room_actions)]
        drawn(page, 0)
        press(page, actions[:-1])
        page.keyboard.press(KEYS[tiny.P])
        expect(page.locator("#status")).to_contain_text("Placement test passed")
        expect(page.locator("#status")).to_have_class("notice good")
        expect(page.get_by_role("button", name="Go on")).to_be_visible()
    assert site.store.workers.get(worker.worker_id).placement_passed_at is not None


def test_only_the_part_that_counts_asks_before_it_is_skipped(browser: Browser, site: VerifySite) -> None:
    with window(browser, site, site.worker(ready=False)) as page:
        asked: list[str] = []

        def dismiss(dialog: Dialog) -> None:
            asked.append(dialog.message)
            dialog.dismiss()

        page.on("dialog", dismiss)
        page.goto(f"{site.pages}/placement?passed")
        expect(page.get_by_text("All your answers are right.")).to_be_visible()
        page.get_by_role("button", name="Begin").click()
        drawn(page, 0)
        expect(page.get_by_text("All your answers are right.")).to_be_hidden()
        for number, said in ((1, "Part 1 of 3 was skipped."), (2, "Part 2 of 3 was skipped. Now the last part")):
            page.get_by_role("button", name="Skip this part").click()
            expect(page.locator("#status")).to_contain_text(said)
            shown = f"practice, part {number + 1} of 3" if number < 2 else "placement test"
            expect(page.locator("#progress")).to_have_text(shown)
            drawn(page, 0)
        expect(page.locator("#frame")).to_be_focused()
        page.get_by_role("button", name="Skip this part").click()
        expect(page.locator("#frame")).to_be_focused()
        page.keyboard.press("ArrowLeft")  # The test goes on.
        drawn(page, 1)
        assert [message.partition("?")[0] for message in asked] == ["Skip the placement test"]


def test_the_placement_test_waits_for_its_script(browser: Browser, site: VerifySite) -> None:
    with window(browser, site, site.worker(ready=False)) as page:
        held: list[Route] = []
        page.route("**/play.*/connection.js", lambda route: held.append(route))
        page.goto(f"{site.pages}/placement")
        begin = page.get_by_role("button", name="Begin")
        expect(begin).to_be_disabled()
        while not held:
            page.wait_for_timeout(10)
        held[0].continue_()
        begin.click()
        drawn(page, 0)


@pytest.mark.parametrize("by_key", [True, False])
def test_the_device_is_measured(browser: Browser, site: VerifySite, by_key: bool) -> None:
    worker = site.worker(ready=False)
    settings: dict[str, Any] = {} if by_key else {"viewport": PHONE, "has_touch": True}
    with window(browser, site, worker, **settings) as page:
        page.goto(f"{site.pages}/device")
        with page.expect_response("**/device"):
            if by_key:
                page.keyboard.press("ArrowUp")
            else:
                page.get_by_role("button", name="I have no keyboard").tap()
        expect(page.locator("#outcome")).to_be_visible()
    device = site.store.workers.get(worker.worker_id).device
    assert (device["keyboard"], device["touch"]) == (by_key, not by_key)
    assert device["frame_ms"] > 0


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[VerifySite, list[str]]]:
    """A collection with a text that three have verified, and one in review; addresses of the hosts' pages."""
    with verify_site(tmp_path_factory.mktemp("filled")) as site:
        author = site.worker()
        walked = site.text(author, "1")

        async def play() -> None:
            async with browsers(site, *(site.worker() for _ in range(3))) as people:
                for person in people:
                    path = person.claim()
                    await person.follow(path)
                    await person.post(f"{path}/hand-in", **{"flag-1-navigation-unclear": "on"})

        with ThreadPoolExecutor(1) as thread:  # Chromium has this one's event loop.
            thread.submit(asyncio.run, play()).result()
        failed = site.text(author, "2", failures=[FAILURE], evidence={"pastes": 2})
        texts = [f"/review/{text.text_id}" for text in (walked, failed)]
        yield site, ["/review", *texts, f"{texts[0]}/walks/described", "/workers", "/ledger"]


@pytest.mark.parametrize(
    ("language", "settings", "scheme"),
    [
        ("en", {}, "light"),
        ("hi", {"viewport": PHONE}, "dark"),
        ("hi", {"viewport": {"width": 768, "height": 1024}}, "light"),
    ],
    ids=["wide", "phone", "tablet"],
)
def test_hosts_pages_fit_and_are_legible(
    browser: Browser, filled: tuple[VerifySite, list[str]], language: str, settings: dict[str, Any], scheme: Any
) -> None:
    site, addresses = filled
    with window(browser, site, site.host, color_scheme=scheme, **settings) as page:
        for address in addresses:
            page.goto(f"{site.site}/{language}/collect/{NAME}{address}")
            assert not page.evaluate("document.documentElement.scrollWidth > innerWidth"), address
            low = [(ratio, text) for ratio, text in page.evaluate(CONTRASTS) if ratio < 4.5]
            assert low == [], address
            tree = page.locator("body").aria_snapshot()
            for role in ("link", "button", "combobox", "textbox", "checkbox", "region", "table", "img"):
                assert not [line for line in tree.splitlines() if line.strip() in (f"- {role}", f"- {role}:")], address

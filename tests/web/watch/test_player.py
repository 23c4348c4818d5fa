"""The player in Chromium: keys, slider, speeds, pictures, live steps, notes of strangers; and without scripts."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import sqlalchemy as sa
from playwright.sync_api import Browser, Page, expect

from arramon_client.world import Action
from arramon_server.runs.run_service import HUMAN
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.records import CommitBatch
from arramon_server.web.film.maker import FilmMaker, FilmSettings
from tests import tiny
from tests.web.leaderboard_site import OPEN_RUN, LeaderboardSite
from tests.web.watch.test_access import LIVE_RUN, OWN, PUBLIC, advance, begin, served

ADDRESS = f"/en/runs/{OPEN_RUN}/episodes/quokka-0"
LAST = len(tiny.ACTIONS)


@contextmanager
def opened(browser: Browser, address: str, *, own_clock: bool = False, **settings: object) -> Iterator[Page]:
    """A page on which nothing may go wrong, once its player is ready; with a clock of its own, it can be stopped."""
    context = browser.new_context(**settings)  # type: ignore[arg-type]
    page, problems = context.new_page(), list[str]()
    if own_clock:
        page.clock.install()
    page.on("console", lambda message: problems.append(message.text))
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.goto(address)
    if settings.get("java_script_enabled", True):
        page.wait_for_selector("#watch[data-ready]", state="attached")
    yield page
    assert problems == []
    context.close()


def stop_clock(page: Page) -> None:
    """Let no time pass on a page with its own clock: the player might be at its end before a busy machine goes on."""
    page.clock.pause_at(page.evaluate("Date.now()") / 1000 + 1)


def shown_width(page: Page) -> int:
    """Width of the frame's picture, once it is decoded."""
    decoded = "image => image.decode().then(() => image.naturalWidth)"
    return int(page.locator("[data-field=frame]").evaluate(decoded))


def field(page: Page, name: str) -> str:
    return page.locator(f"[data-field={name}]").first.inner_text()


def trail(page: Page) -> int:
    """Number of places in the way that the shown map draws."""
    points = page.locator("[data-map]:not([hidden]) .trail").get_attribute("points") or ""
    return len(points.split())


def test_keys_step_and_the_address_follows(shown: LeaderboardSite, browser: Browser) -> None:
    with opened(browser, f"{shown.site.address}{ADDRESS}?step=1") as page:
        assert (field(page, "step"), field(page, "action"), trail(page)) == ("1", "forward", 2)
        page.keyboard.press("ArrowRight")
        expect(page.locator("[data-field=answer]")).to_have_text("Picked up: dotted purple hourglass.")
        page.keyboard.press("ArrowRight")
        expect(page.locator("[data-field=phase]")).to_have_text("Turn 1, Assembly")
        expect(page.locator("[data-field=carried]")).to_have_text("dotted purple hourglass")
        expect(page.locator("[data-map='1-assembly']")).to_be_visible()
        expect(page.locator("[data-map='1-navigation']")).to_be_hidden()
        page.wait_for_url("**?step=3")
        page.keyboard.press("n")
        expect(page.locator("[data-field=answer]")).to_have_text("Placed in column 3, row 3, on level 1.")
        page.keyboard.press("p")
        expect(page.locator("[data-field=step]")).to_have_text("2")
        page.keyboard.press("End")
        expect(page.locator("[data-field=step]")).to_have_text(str(LAST))
        page.keyboard.press("Home")
        page.wait_for_url("**?step=0")
        assert page.locator("[data-field=link]").get_attribute("href") == f"{ADDRESS}?step=0"


def test_it_plays_to_the_end_pauses_and_begins_again(shown: LeaderboardSite, browser: Browser) -> None:
    with opened(browser, shown.site.address + ADDRESS, own_clock=True) as page:
        page.select_option("[data-field=speed]", "16")
        page.keyboard.press("Tab")
        page.locator("h1").click()
        stop_clock(page)
        page.keyboard.press(" ")
        expect(page.get_by_role("button", name="Pause")).to_be_visible()
        page.clock.resume()
        expect(page.locator("[data-field=step]")).to_have_text(str(LAST))
        expect(page.get_by_role("button", name="Play")).to_be_visible()
        stop_clock(page)
        page.get_by_role("button", name="Play").click()
        page.get_by_role("button", name="Pause").click()
        expect(page.get_by_role("button", name="Play")).to_be_visible()
        assert int(field(page, "step")) < LAST


def test_slider_events_and_pictures(shown: LeaderboardSite, browser: Browser) -> None:
    with opened(browser, shown.site.address + ADDRESS) as page:
        page.get_by_role("slider", name="Step").fill("7")
        expect(page.locator("[data-field=step]")).to_have_text("7")
        assert shown_width(page) == 448
        page.get_by_role("link", name="2: picked up").click()
        expect(page.locator("[data-field=step]")).to_have_text("2")
        for kind in ("depth", "segmentation"):
            page.select_option("[data-field=kind]", kind)
            expect(page.locator("[data-field=frame]")).to_have_attribute("src", f"{FRAMES}2.jpg?kind={kind}")
        assert page.locator("[data-field=strip] .strip-navigation").count() == 2
        assert page.locator("[data-field=strip] .mark-placed").count() == 2


FRAMES = f"/runs/{OPEN_RUN}/episodes/quokka-0/frames/"


def test_without_scripts_links_lead_from_step_to_step(shown: LeaderboardSite, browser: Browser) -> None:
    with opened(browser, f"{shown.site.address}{ADDRESS}?step=2", java_script_enabled=False) as page:
        assert field(page, "answer") == "Picked up: dotted purple hourglass."
        assert trail(page) == 3
        assert page.locator("[data-field=frame]").get_attribute("src") == f"{FRAMES}2.jpg"
        page.get_by_role("link", name="Step on").click()
        expect(page).to_have_url(re.compile(r"\?step=3$"))
        expect(page.locator("[data-field=phase]")).to_have_text("Turn 1, Assembly")
        assert trail(page) == 1
        page.get_by_role("link", name="Step back").click()
        expect(page.locator("[data-field=step]")).to_have_text("2")
        assert not page.locator("[data-field=controls]").is_visible()


NOTE = {
    "read": {"steps": [{"do": "<script>walk</script>"}, {"do": "turn"}], "target": {"kind": "mug"}},
    "step": 2, "goal": [1.0, 2.0], "thought": "<img src=x onerror=alert(1)>", "<b>key</b>": "&amp;",
}  # fmt: skip


@pytest.mark.parametrize("scripts", [True, False])
def test_notes_are_shown_as_text(web: LeaderboardSite, browser: Browser, scripts: bool) -> None:
    begin(web, steps=0)
    advance(web, LIVE_RUN, 0, 2, json.dumps(NOTE))
    with served(web, OWN) as site:
        address = f"{site.address}/en/runs/{LIVE_RUN}/episodes/quokka-1?step=1"
        with opened(browser, address, java_script_enabled=scripts) as page:
            note = page.locator("[data-field=note]")
            expect(note.locator("li")).to_have_text(["<script>walk</script>", "turn", "Object: mug"])
            expect(note.locator("[aria-current=step]")).to_have_text("turn")
            expect(note.locator("dd")).to_have_text(["2", "<img src=x onerror=alert(1)>", "&amp;"])
            expect(note.locator("dt").last).to_have_text("<b>key</b>")
            assert note.locator("script, img, b").count() == 0
            goal = page.locator("[data-map='1-navigation'] [data-field=goal]").get_attribute("transform")
            assert goal is not None
            assert [float(number) for number in re.findall(r"[\d.]+", goal)] == [27.44, 24.0, 1.0]


def test_new_steps_appear_while_it_is_played(web: LeaderboardSite, browser: Browser) -> None:
    begin(web, steps=2)
    with served(web, OWN) as site, opened(browser, f"{site.address}/en/runs/{LIVE_RUN}/episodes/quokka-1") as page:
        expect(page.locator("[data-field=live]")).to_be_visible()
        assert field(page, "step") == "2"
        advance(web, LIVE_RUN, 2, 4)
        expect(page.locator("[data-field=step]")).to_have_text("4")
        expect(page.locator("[data-map='1-assembly']")).to_be_visible()
        advance(web, LIVE_RUN, 4, 8)
        placed = page.locator("[data-map='2-assembly'] .thing title")
        expect(placed).to_have_text(["dotted white bowl", "dotted purple hourglass"])  # what turn 1 left there
        page.keyboard.press("Home")
        expect(page.locator("[data-field=step]")).to_have_text("0")
        advance(web, LIVE_RUN, 8, LAST)
        expect(page.locator("[data-field=last]")).to_have_text(str(LAST))
        assert field(page, "step") == "0"  # who looks back stays there
        expect(page.locator("[data-field=live]")).to_be_hidden()
        expect(page.get_by_text("Watch the next one")).to_be_hidden()


def test_the_truth_is_shown_when_the_episode_has_ended(web: LeaderboardSite, browser: Browser) -> None:
    begin(web, steps=2)
    with served(web, PUBLIC) as site, opened(browser, f"{site.address}/en/runs/{LIVE_RUN}/episodes/quokka-1") as page:
        assert page.locator(".watch .truth, .watch .wanted, [data-field=ndtw]").count() == 0
        advance(web, LIVE_RUN, 2, LAST)
        expect(page.locator("[data-field=ndtw]")).to_be_visible()
        page.keyboard.press("Home")
        expect(page.locator("[data-map='1-navigation'] .wanted")).to_be_visible()
        expect(page.locator("[data-field=distance]")).to_have_text("3.5 units")


def test_maps_come_when_a_person_has_ended_the_episode(web: LeaderboardSite, browser: Browser) -> None:
    begin(web, steps=2, agent=HUMAN)
    with served(web, OWN) as site, opened(browser, f"{site.address}/en/runs/{LIVE_RUN}/episodes/quokka-1") as page:
        assert page.get_by_text("The reference is shown when the episode is over").is_visible()
        advance(web, LIVE_RUN, 2, 4)
        expect(page.locator("[data-field=step]")).to_have_text("4")  # frames and facts follow without maps
        expect(page.locator("[data-map]")).to_have_count(0)
        advance(web, LIVE_RUN, 4, LAST)
        expect(page.locator("[data-field=ndtw]")).to_be_visible()
        page.keyboard.press("Home")
        expect(page.locator("[data-map='1-navigation'] .wanted")).to_be_visible()
        expect(page.get_by_text("The reference is shown when the episode is over")).to_have_count(0)


def test_a_film_plays_from_its_file(shown: LeaderboardSite, browser: Browser, tmp_path: Path) -> None:
    settings = FilmSettings(tmp_path / "film.html", "hi", None, 8.0, 96, 60)
    FilmMaker(shown.database, shown.folder, "raster").make(OPEN_RUN, "quokka-0", settings)
    with opened(browser, settings.path.as_uri()) as page:
        page.keyboard.press("End")
        expect(page.locator("[data-field=step]")).to_have_text(str(LAST))
        assert shown_width(page) == 96
        page.get_by_role("link", name="2: उठाया").click()
        expect(page.locator("[data-field=answer]")).to_contain_text("उठाया गया")


def test_a_dead_server_is_said_and_single_steps_still_work(shown: LeaderboardSite, browser: Browser) -> None:
    context = browser.new_context()
    page = context.new_page()
    page.route("**/moments.json*", lambda route: route.abort())
    page.goto(f"{shown.site.address}{ADDRESS}?step=2")
    expect(page.get_by_role("alert")).to_contain_text("The steps could not be loaded")
    page.get_by_role("link", name="Step on").click()
    expect(page.locator("[data-field=step]")).to_have_text("3")
    context.close()


@pytest.mark.parametrize("width", [360, 768, 1440])
def test_nothing_scrolls_sideways(web: LeaderboardSite, browser: Browser, width: int) -> None:
    begin(web, steps=0)
    advance(web, LIVE_RUN, 0, 3, json.dumps({"thought": "x" * 900}))
    with served(web, OWN) as site:
        for path in (f"/hi/runs/{LIVE_RUN}/episodes/quokka-1", "/hi/watch"):
            context = browser.new_context(viewport={"width": width, "height": 740})
            page = context.new_page()
            page.goto(site.address + path)
            assert page.evaluate("document.documentElement.scrollWidth") == width
            context.close()


def test_a_thousand_keys_lose_nothing(shown: LeaderboardSite, browser: Browser) -> None:
    with opened(browser, shown.site.address + ADDRESS) as page:
        page.evaluate(
            """() => {
                for (let n = 0; n < 1000; n++) {
                    document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
                }
            }"""
        )
        expect(page.locator("[data-field=step]")).to_have_text(str(LAST))


def test_events_are_listed_as_they_happen_and_keep_the_focus(web: LeaderboardSite, browser: Browser) -> None:
    begin(web, steps=2)
    with served(web, OWN) as site, opened(browser, f"{site.address}/en/runs/{LIVE_RUN}/episodes/quokka-1") as page:
        events = page.locator(".watch-events")
        expect(events).to_contain_text("Nothing stands out so far.")
        advance(web, LIVE_RUN, 2, 4)
        expect(events.locator("li")).to_have_text(["2: picked up"])
        events.get_by_role("link").focus()
        advance(web, LIVE_RUN, 4, 5)
        expect(events.locator("li")).to_have_text(["2: picked up", "4: placed"])
        assert page.evaluate("document.activeElement.textContent") == "2: picked up"
        events.get_by_role("link", name="4: placed").click()
        expect(page.locator("[data-field=step]")).to_have_text("4")
        advance(web, LIVE_RUN, 5, LAST)
        expect(events.locator("li")).to_have_text(["2: picked up", "4: placed", "10: picked up", "12: placed"])


def test_blocked_steps_in_a_row_are_listed_once(web: LeaderboardSite, browser: Browser) -> None:
    begin(web, steps=0)
    with served(web, OWN) as site, opened(browser, f"{site.address}/en/runs/{LIVE_RUN}/episodes/quokka-1") as page:
        batch, (claim,) = CommitBatch(), web.journal.open_claims(LIVE_RUN)
        for step in range(14):
            batch.add_step(LIVE_RUN, "quokka-1", claim.fence, step, Action.FORWARD)
        web.journal.commit(batch)
        listed = page.locator(".watch-events li")
        expect(listed).to_have_text(["6: left the path", "10: blocked"])
        page.reload()
        expect(listed).to_have_text(["6: left the path", "10: blocked"])  # as the server lists them


def test_a_run_that_is_deleted_while_it_is_watched_is_said_to_be_gone(web: LeaderboardSite, browser: Browser) -> None:
    begin(web, steps=3)
    context = browser.new_context()
    page = context.new_page()
    with served(web, OWN) as site:
        page.goto(f"{site.address}/hi/runs/{LIVE_RUN}/episodes/quokka-1")
        page.wait_for_selector("#watch[data-ready]", state="attached")
        with web.database.write() as connection:
            for table in (tables.steps, tables.episodes, tables.runs):
                connection.execute(sa.delete(table).where(table.c.run_id == LIVE_RUN))
        expect(page.get_by_role("alert")).to_contain_text("यह एपिसोड अब यहाँ नहीं है")
        expect(page.locator("[data-field=live]")).to_be_hidden()
        page.keyboard.press("Home")
        expect(page.locator("[data-field=step]")).to_have_text("0")  # what is loaded is still shown
        asked = list[str]()
        page.on("request", lambda request: asked.append(request.url))
        page.keyboard.press("ArrowRight")
        expect(page.locator("[data-field=step]")).to_have_text("1")
        assert not [address for address in asked if "moments.json" in address]
    context.close()

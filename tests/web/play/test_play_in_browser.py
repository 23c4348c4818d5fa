"""Play in Chromium: by keys and by buttons, in both languages, through reloads, a second tab and faults."""

import re
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from arramon_client.world import Action
from arramon_server.web.play.practice_split import practice_split
from tests import tiny
from tests.web.play.page_client import PageServer
from tests.web.test_browser import CONTRASTS, PHONE

KEYS = {tiny.F: "ArrowUp", tiny.L: "ArrowLeft", tiny.R: "ArrowRight", tiny.P: "Space"}
OTHER_KEYS = {tiny.F: "w", tiny.L: "a", tiny.R: "d", tiny.P: "Enter"}

BYTES = 200_000
"""Limit of a page with its scripts and styles, as sent, without fonts."""


NAMES = """() => {
    const texts = [...document.querySelectorAll("#result svg.map .names text")];
    const isCovering = (text) => [...text.closest("svg").querySelectorAll("polyline")].some((way) => {
        const { x, y, width, height } = text.getBBox(), length = way.getTotalLength();
        return Array.from({ length: 200 }, (_, n) => way.getPointAtLength(length * n / 199))
            .some((point) => point.x > x && point.x < x + width && point.y > y && point.y < y + height);
    });
    return [texts.length, texts.filter(isCovering).length];
}"""
"""Number of names on the maps of the streets, and of those that cover a path."""


@contextmanager
def window(browser: Browser, server: PageServer, *, losing: bool = False, **settings: object) -> Iterator[Page]:
    """A window on the site. Nothing may go wrong in it, unless its connection is to be lost."""
    context: BrowserContext = browser.new_context(**settings)  # type: ignore[arg-type]
    page, problems, elsewhere = context.new_page(), [], []
    page.on("console", lambda message: problems.append(message.text))
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("request", lambda request: elsewhere.append(request.url))
    yield page
    assert [url for url in elsewhere if not url.startswith((server.site, "data:"))] == []
    assert losing or problems == []
    context.close()


def start(page: Page, server: PageServer, language: str = "en", split: str = "tiny", episodes: int = 1) -> None:
    page.goto(f"{server.site}/{language}/play")
    page.select_option('select[name="split"]', split)
    page.fill('input[name="episodes"]', str(episodes))
    page.click("#start button")
    drawn(page, 0)


def drawn(page: Page, step: int) -> None:
    """Waits until the frame of a step is on the page."""
    expect(page.locator("html")).to_have_attribute("data-drawn", re.compile(rf" {step}$"))


def press(page: Page, actions: tuple[int, ...], first: int = 0, keys: dict[Action, str] = KEYS) -> None:
    """Presses a key for each action, and waits for its frame."""
    for step, action in enumerate(actions, start=first):
        page.keyboard.press(keys[Action(action)])
        drawn(page, step + 1)


@pytest.mark.parametrize(
    ("language", "instruction", "picked_up", "keys"),
    [
        ("en", "Go on to the striped red mug.", "You picked up: striped red mug", KEYS),
        ("hi", "धारीदार लाल मग तक चलें।", "आपने उठाया: धारीदार लाल मग", OTHER_KEYS),
    ],
)
def test_a_whole_episode_by_keys(
    browser: Browser, server: PageServer, language: str, instruction: str, picked_up: str, keys: dict[Action, str]
) -> None:
    with window(browser, server) as page:
        start(page, server, language)
        expect(page.locator("#instruction")).to_have_text(instruction)
        press(page, tiny.ACTIONS[:3], keys=keys)
        expect(page.locator("#outcome")).to_have_text(picked_up)
        expect(page.locator("#landing")).to_be_visible()
        page.reload()
        drawn(page, 3)
        press(page, tiny.ACTIONS[3:-1], first=3, keys=keys)
        page.keyboard.press(keys[tiny.P])
        expect(page.locator("#result svg.map")).to_have_count(2)
        expect(page.locator("#result tbody td").last).to_have_text("1.000")
        expect(page.locator("#result .verdicts .right")).to_have_count(2)
        assert page.evaluate(NAMES) == [2, 0]
        expect(page.locator("#begin")).to_be_visible()
        expect(page.locator("#status.good")).to_be_visible()
        page.click("#publish button")
        page.click("#status a")
        expect(page.locator("main")).to_contain_text("human")
        page.goto(f"{server.site}/{language}/people?split=tiny&language={language}")
        expect(page.locator("tbody tr").first).to_contain_text("1.000")
        expect(page.locator("tbody tr").first).to_contain_text("landing_diagram=on")


def test_the_tutorial_ends_with_the_placement_test(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        page.goto(f"{server.site}/en/play")
        page.click("#practice button")
        for number, episode in enumerate(practice_split().episodes.values()):
            if number:
                expect(page.locator("#result .verdicts .right")).to_have_count(2)
                page.click("#next button")
            actions = [action for turn in episode.turns for action in (*turn.actions, *turn.room_actions)]
            expect(page.locator("html")).to_have_attribute("data-drawn", f"{episode.episode_id} 0")
            press(page, tuple(actions[:-1]))
            page.keyboard.press("Space")
        expect(page.locator("#status.good")).to_contain_text("Placement test passed")
        expect(page.locator("#start")).to_be_visible()
        expect(page.locator("#practise-again")).to_be_hidden()


def test_a_placement_test_that_was_given_up_can_be_taken_again(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        page.goto(f"{server.site}/en/play")
        page.on("dialog", lambda dialog: dialog.accept())
        page.click("#practice button")
        first, second, last = practice_split().episodes.values()
        for episode in (first, second):
            expect(page.locator("html")).to_have_attribute("data-drawn", f"{episode.episode_id} 0")
            page.click("#give-up")
            page.click("#next button")
        expect(page.locator("html")).to_have_attribute("data-drawn", f"{last.episode_id} 0")
        press(page, last.turns[0].actions)  # picks up, and does not place
        page.click("#give-up")
        expect(page.locator("#status")).to_contain_text("Placement test not passed")
        expect(page.locator("#status.good")).to_have_count(0)
        expect(page.locator("#result .verdicts li").first).to_contain_text("You gave up before you put it down.")
        page.click("#practise-again")
        expect(page.locator("html")).to_have_attribute("data-drawn", f"{first.episode_id} 0")


def test_a_reload_in_the_tutorial_loses_nothing(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        page.goto(f"{server.site}/en/play")
        page.click("#practice button")
        first, second, _ = practice_split().episodes
        expect(page.locator("html")).to_have_attribute("data-drawn", f"{first} 0")
        press(page, (tiny.L, tiny.R))
        page.reload()
        drawn(page, 2)
        expect(page.locator("#progress")).to_have_text("practice, part 1 of 3")
        page.on("dialog", lambda dialog: dialog.accept())
        page.click("#give-up")
        expect(page.locator("#result .verdicts .wrong")).to_have_count(2)
        page.reload()
        expect(page.locator("#result .verdicts .wrong")).to_have_count(2)
        expect(page.locator("#status")).to_contain_text("Part 1 of 3 is over")
        expect(page.locator("#game")).to_be_hidden()
        expect(page.locator("#leave button")).to_have_text("Leave the practice")
        page.click("#next button")
        expect(page.locator("html")).to_have_attribute("data-drawn", f"{second} 0")
        page.click("#game .leave")
        expect(page.locator("#status")).to_have_text("You have left the practice. Start an episode when you like.")
        page.reload()
        expect(page.locator("#start")).to_be_visible()


def test_a_tutorial_that_the_server_has_forgotten_begins_again(browser: Browser, tmp_path: Path) -> None:
    server = PageServer(tmp_path)
    with window(browser, server) as page:
        page.goto(f"{server.site}/en/play")
        page.click("#practice button")
        drawn(page, 0)
        press(page, (tiny.L,))
        page.goto("about:blank")  # so that it does not come back by itself
        assert server.stop() == 0
        server.start()
        page.goto(f"{server.site}/en/play")
        expect(page.locator("#status")).to_have_text("The server no longer had your practice, so it begins again.")
        drawn(page, 0)
        press(page, (tiny.L,))
        expect(page.locator("#status")).to_be_hidden()
    assert server.stop() == 0


def test_every_outcome_is_said(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        start(page, server)
        page.keyboard.press("Space")
        drawn(page, 1)
        expect(page.locator("#outcome")).to_have_text("Nothing is within reach.")
        press(page, (tiny.L, tiny.R, tiny.F, tiny.F), first=1)
        expect(page.locator("#outcome")).to_have_text("You moved one step.")
        press(page, (tiny.P, tiny.L), first=5)
        expect(page.locator("#outcome")).to_have_text("You turned left.")
        buttons = page.locator(".pad").bounding_box()
        press(page, (tiny.F,), first=7)
        expect(page.locator("#outcome")).to_contain_text("You can step only while you face a wall straight")
        assert page.locator(".pad").bounding_box() == buttons  # there is room for the longer message
        press(page, (tiny.P,), first=8)
        expect(page.locator("#outcome")).to_contain_text("You can place only while you face a wall straight")
        press(page, (tiny.P,), first=9)
        for place in ("#outcome", "#flash"):
            expect(page.locator(place)).to_have_text(re.compile(r"The try cost a step\. \(2\)$"))
        expect(page.locator("#steps")).to_have_text("16")
        expect(page.locator("#heading")).to_have_text("330° from the start of this part")


def test_buttons_on_a_phone(browser: Browser, server: PageServer) -> None:
    with window(browser, server, viewport=PHONE, has_touch=True, is_mobile=True) as page:
        start(page, server)
        for step, action in enumerate(tiny.ACTIONS[:5]):
            button = page.locator(f'[data-action="{int(action)}"]')
            box = button.bounding_box()
            assert box is not None
            assert min(box["width"], box["height"]) >= 44
            button.tap()
            drawn(page, step + 1)
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
        page.on("dialog", lambda dialog: dialog.accept())
        page.locator("#give-up").tap()
        expect(page.locator("#result h2").first).to_be_visible()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_contrast_and_width(browser: Browser, server: PageServer, scheme: str) -> None:
    # 360 pixels are also what a window of 720 has at 200% zoom.
    with window(browser, server, color_scheme=scheme, viewport=PHONE) as page:
        start(page, server, "hi")
        press(page, tiny.ACTIONS[:4])
        map_top, pad_top = page.evaluate(
            "['#landing', '.pad'].map((part) => document.querySelector(part).getBoundingClientRect().top)"
        )
        assert abs(map_top - pad_top) < 2  # beside the buttons, in sight
        low = [(ratio, text) for ratio, text in page.evaluate(CONTRASTS) if ratio < 4.5]
        assert low == []
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]


def test_a_second_tab_takes_over(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as first:
        start(first, server)
        press(first, tiny.ACTIONS[:1])
        second = first.context.new_page()
        second.goto(f"{server.site}/en/play")
        drawn(second, 1)
        expect(first.locator("#status")).to_have_text("This run is played in another window now. Here it has stopped.")
        for button in ("#interact", "[data-action='0']"):
            expect(first.locator(button)).to_be_disabled()
            expect(first.locator(button)).to_have_css("opacity", "0.4")  # seen to be disabled
        press(second, tiny.ACTIONS[1:2], first=1)
        first.keyboard.press("ArrowUp")  # does nothing
        first.click("#again button")
        drawn(first, 2)
        expect(first.locator("#interact")).to_have_css("opacity", "1")
        expect(second.locator("#status")).to_contain_text("another window")
        press(first, tiny.ACTIONS[2:3], first=2)


def test_a_restarted_server_is_found_again(browser: Browser, tmp_path: Path) -> None:
    server = PageServer(tmp_path)
    with window(browser, server, losing=True) as page:
        start(page, server)
        press(page, tiny.ACTIONS[:1])
        server.kill()
        expect(page.locator("#status")).to_contain_text("The connection was lost.")
        page.keyboard.press("ArrowUp")  # is sent once the page is connected again
        server.start()
        drawn(page, 2)
        expect(page.locator("#status")).to_be_hidden()
        press(page, tiny.ACTIONS[2:3], first=2)
        expect(page.locator("#outcome")).to_have_text("You picked up: striped red mug")
    assert server.stop() == 0


def test_a_full_disk_loses_nothing(browser: Browser, tmp_path: Path) -> None:
    server = PageServer(tmp_path, log=tmp_path / "log")
    with window(browser, server, losing=True) as page:
        start(page, server)
        press(page, tiny.ACTIONS[:1])
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
        page.keyboard.press("ArrowUp")
        expect(page.locator("#status")).to_contain_text(
            re.compile("cannot save steps|not available|connection was lost")
        )
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)
        drawn(page, 2)
        press(page, tiny.ACTIONS[2:3], first=2)
        expect(page.locator("#outcome")).to_have_text("You picked up: striped red mug")
    assert server.stop() == 0


@pytest.mark.parametrize(
    ("language", "text"), [("en", "Playing needs JavaScript"), ("hi", "खेलने के लिए जावास्क्रिप्ट चाहिए")]
)
def test_without_scripts_the_page_says_what_is_missing(
    browser: Browser, server: PageServer, language: str, text: str
) -> None:
    with window(browser, server, java_script_enabled=False) as page:
        page.goto(f"{server.site}/{language}/play")
        # Chromium, controlled from outside, keeps <noscript> out of sight although it runs no scripts.
        assert text in (page.locator("noscript").text_content() or "")
        expect(page.locator("#start")).to_be_hidden()


def test_the_page_is_small_and_runs_nothing_inline(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        sizes: dict[str, int] = {}
        page.on("requestfinished", lambda done: sizes.update({done.url: done.sizes()["responseBodySize"]}))
        response = page.goto(f"{server.site}/en/play")
        page.wait_for_load_state("networkidle")
        assert response is not None
        policy = response.headers["content-security-policy"]
    assert "unsafe" not in policy
    small = {url: size for url, size in sizes.items() if not url.endswith(".woff2")}
    assert len(small) >= 8
    assert sum(small.values()) < BYTES


def test_between_episodes_a_person_reads_how_the_last_went(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        start(page, server, episodes=2)
        press(page, (*tiny.ACTIONS[:3], *tiny.ACTIONS[4:-1]))
        page.keyboard.press("Space")
        expect(page.locator("#result .verdicts .wrong").first).to_contain_text("one tile, or one level, away")
        expect(page.locator("#game")).to_be_hidden()
        page.reload()
        expect(page.locator("#next")).to_contain_text("Its time begins when you press this.")
        expect(page.locator("#result .verdicts .wrong").first).to_contain_text("one tile, or one level, away")
        expect(page.locator("#game")).to_be_hidden()
        page.click("#next button")
        drawn(page, 0)
        expect(page.locator("#result")).to_be_empty()
        page.on("dialog", lambda dialog: dialog.accept())
        page.click("#give-up")
        expect(page.locator("#totals")).to_contain_text("Objects right in the whole run: 0 of 4.")
        expect(page.locator("#totals li a")).to_have_count(2)
        page.reload()
        expect(page.locator("#publish")).to_be_hidden()
        page.click("#last button")
        expect(page.locator("#publish")).to_be_visible()
        page.click("#totals li a >> nth=0")
        expect(page.locator("svg.map").first).to_be_visible()


def test_another_language_says_that_a_run_waits(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        start(page, server)
        page.goto(f"{server.site}/hi/play")
        expect(page.locator("#elsewhere")).to_contain_text("English")
        page.go_back()
        drawn(page, 0)
        page.on("dialog", lambda dialog: dialog.accept())
        page.click("#game .leave")
        expect(page.locator("#status")).to_have_text("You have left the run. Start another one when you like.")
        page.reload()
        expect(page.locator("#start")).to_be_visible()


@pytest.mark.parametrize("size", [{"width": 740, "height": 360}, {"width": 640, "height": 450}])
def test_a_low_window_shows_picture_and_buttons(browser: Browser, server: PageServer, size: dict[str, int]) -> None:
    with window(browser, server, viewport=size) as page:
        start(page, server)
        for part in ("#frame", "#instruction", "#interact"):
            expect(page.locator(part)).to_be_in_viewport(ratio=0.9)
        assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]

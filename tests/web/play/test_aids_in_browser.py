"""Aids in Chromium: looking around, zoom, pictures, words for a screen reader; and swipes on a phone."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from tests import tiny
from tests.web.play.page_client import PageServer
from tests.web.play.test_play_in_browser import drawn, press, start, window
from tests.web.test_browser import CONTRASTS, PHONE

ALL = (
    "--play-landing-diagram", "--play-frame-strip", "--play-compass", "--play-look-around", "--play-zoom",
    "--play-pictured-names", "--play-ahead", "--play-scene-words",
)  # fmt: skip

PIXELS = "document.getElementById('frame').toDataURL()"

SWIPE = """([x, y]) => {
    const area = document.querySelector(".frame"), box = area.getBoundingClientRect();
    const touch = (name, right, down) => area.dispatchEvent(new PointerEvent(name, {
        pointerType: "touch", isPrimary: true, bubbles: true, clientX: box.x + 150 + right, clientY: box.y + 150 + down,
    }));
    touch("pointerdown", 0, 0);
    touch("pointerup", x, y);
}"""


@pytest.fixture(scope="module")
def aided(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageServer]:
    server = PageServer(tmp_path_factory.mktemp("data"), *ALL)
    yield server
    assert server.stop() == 0


def looked(page: Page, degrees: int) -> None:
    expect(page.locator("html")).to_have_attribute("data-looked", str(degrees))


def test_looking_around_ends_with_the_next_key(browser: Browser, aided: PageServer) -> None:
    with window(browser, aided) as page:
        start(page, aided)
        ahead = page.evaluate(PIXELS)
        page.keyboard.press("e")
        looked(page, 30)
        right = page.evaluate(PIXELS)
        assert right != ahead
        expect(page.locator("#looking")).to_have_text("30° to your right, without turning")
        for degrees in (0, 330):
            page.keyboard.press("q")
            looked(page, degrees)
        expect(page.locator("#looking")).to_have_text("30° to your left, without turning")
        expect(page.locator("#steps")).to_have_text("150")
        page.keyboard.press("ArrowRight")
        drawn(page, 1)
        expect(page.locator("#looking")).to_be_empty()
        assert page.evaluate(PIXELS) == right
        expect(page.locator("#strip canvas")).to_have_count(1)


def test_words_and_zoom(browser: Browser, aided: PageServer) -> None:
    with window(browser, aided) as page:
        start(page, aided)
        expect(page.locator("#ahead")).to_have_text("Nothing is within reach.")
        press(page, (tiny.F,))
        expect(page.locator("#outcome")).to_have_text("You moved one step. Within reach: striped red mug.")
        for _ in range(2):  # said again when asked again
            page.keyboard.press("x")
            expect(page.locator("#described")).to_contain_text(
                "Object 1 of 2: find it. You carry: nothing. Steps left: 149. Within reach: striped red mug."
            )
            expect(page.locator("#described")).to_contain_text("striped red mug, steps: 2")
        page.keyboard.press("z")
        expect(page.locator("#zoom")).to_have_attribute("aria-pressed", "true")
        assert "zoomed" in (page.locator("#frame").get_attribute("class") or "")
        press(page, (tiny.P, tiny.R), first=1)
        expect(page.locator("#described")).to_be_empty()
        expect(page.locator("#outcome")).to_have_text(
            "You turned right. No tile ahead: you do not face a wall straight."
        )
        press(page, (tiny.L, tiny.F), first=3)
        expect(page.locator("#ahead")).to_have_text("Tile ahead: column 3, row 3, free.")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pictures_contrast_and_width(browser: Browser, aided: PageServer, scheme: str) -> None:
    with window(browser, aided, color_scheme=scheme, viewport=PHONE) as page:
        start(page, aided, "hi")
        page.keyboard.press("x")
        expect(page.locator("#described")).to_contain_text("आगे:")
        with page.expect_response(lambda response: response.url.endswith("/wall_striped.jpg")) as picture:
            page.click("#names summary")
            page.locator(".names li").last.scroll_into_view_if_needed()
        assert (picture.value.status, picture.value.headers["content-type"]) == (200, "image/jpeg")
        expect(page.locator(".names li").last).to_contain_text("striped wall धारीदार दीवार")
        assert [(ratio, text) for ratio, text in page.evaluate(CONTRASTS) if ratio < 4.5] == []
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]


def test_without_aids_nothing_more_is_shown(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        start(page, server)
        for key in ("e", "z"):
            page.keyboard.press(key)
        for hidden in ("#look", "#zoom", "#names", "#ahead"):
            expect(page.locator(hidden)).to_be_hidden()
        page.keyboard.press("x")
        expect(page.locator("#described")).to_have_text("Object 1 of 2: find it. You carry: nothing. Steps left: 20.")
        assert page.evaluate("document.documentElement.dataset.looked ?? 'never'") == "never"


def test_swipes_are_off_until_turned_on_and_are_remembered(browser: Browser, server: PageServer) -> None:
    with window(browser, server, viewport=PHONE, has_touch=True, is_mobile=True) as page:
        start(page, server)
        page.evaluate(SWIPE, [0, -80])
        page.locator("#swipes input").tap()
        expect(page.locator("#swipes input")).to_be_checked()
        for step, (right, down) in enumerate(((5, -80), (-80, 5), (80, 5))):
            page.evaluate(SWIPE, [right, down])
            drawn(page, step + 1)
        expect(page.locator("#outcome")).to_have_text("You turned right.")
        page.evaluate(SWIPE, [0, 80])
        page.evaluate(SWIPE, [10, -10])
        page.reload()
        drawn(page, 3)
        page.evaluate(SWIPE, [0, -80])
        drawn(page, 4)

"""The pages in Chromium: keyboard, phone, dark mode, without scripts, and accessibility."""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, CDPSession, Page, Route, expect

from tests.web.leaderboard_site import HIDDEN_RUN, OPEN_RUN, PRIVILEGED_RUN, LeaderboardSite

PHONE = {"width": 360, "height": 740}

# The contrast of every text against whatever is painted behind it, as WCAG 2 computes it.
CONTRASTS = """() => {
  const numbers = (colour) => colour.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => {
    const part = (v) => (v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
    return 0.2126 * part(r) + 0.7152 * part(g) + 0.0722 * part(b);
  };
  const behind = (element) => {
    for (let one = element; one; one = one.parentElement) {
      const colour = numbers(getComputedStyle(one).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return colour;
    }
    return matchMedia("(prefers-color-scheme: dark)").matches ? [0, 0, 0] : [255, 255, 255];
  };
  const found = [];
  for (const element of document.querySelectorAll("body *")) {
    const own = [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
    if (!own || !element.checkVisibility()) continue;
    const style = getComputedStyle(element);
    const ink = element.closest("svg") ? style.fill : style.color;
    const [high, low] = [light(numbers(ink)), light(behind(element))].sort((a, b) => b - a);
    found.push([(high + 0.05) / (low + 0.05), element.outerHTML.slice(0, 90)]);
  }
  return found;
}"""


FONTS = {
    "as installed": "",
    "wide": """* { font-family: "DejaVu Sans", Verdana, monospace !important; }""",
    "spaced": "* { letter-spacing: .12em !important; word-spacing: .16em !important; }",
}
"""What the layout is tried in. The first is what a browser finds for the page's own list; the second stands in for
machines with wider fonts, the third for readers who need more space (WCAG 1.4.12), and is wide whatever is installed.
Which of the named fonts are there depends on the machine, so every test says what it was shown in."""


@dataclass
class Reader:
    """A browser's window on the site, and what went wrong in it.

    Attributes:
        problems: what its console said.
        requested_urls: the addresses that it asked for.
        note: writes down what a page was shown in, for the summary.
    """

    page: Page
    site: str
    note: Callable[[str, object], None] = lambda name, value: None
    problems: list[str] = field(default_factory=list)
    requested_urls: list[str] = field(default_factory=list)

    def open(self, path: str) -> Page:
        self.page.goto(self.site + path)
        return self.page

    def open_in_fonts(self, path: str) -> Iterator[tuple[Page, str]]:
        """Open a page in one font after the other; each with what it is drawn in, in words, for messages."""
        for name, style in FONTS.items():
            add = partial(_add_style, style)
            self.page.route(STYLESHEET, add)
            page = self.open(path)
            self.page.unroute(STYLESHEET, add)
            font = f"{name} ({', '.join(self.drawn())})"
            self.note("fonts", font)
            yield page, font

    def drawn(self) -> list[str]:
        """The families that the browser draws the open page in, as it says itself."""
        with closing_session(self.page) as session:
            session.send("DOM.enable")
            session.send("CSS.enable")
            root = session.send("DOM.getDocument")["root"]["nodeId"]
            body = session.send("DOM.querySelector", {"nodeId": root, "selector": "body"})["nodeId"]
            found = session.send("CSS.getPlatformFontsForNode", {"nodeId": body})["fonts"]
        families = sorted({font["familyName"] for font in found})
        assert families
        return families

    def press_until(self, selector: str, key: str = "Tab") -> None:
        """Presses a key until an element has the focus, as somebody does who has no mouse."""
        for _ in range(80):
            self.page.keyboard.press(key)
            if self.page.evaluate("s => document.activeElement.matches(s)", selector):
                return
        raise AssertionError(f"{key} never came to {selector}")


STYLESHEET = re.compile(r"/static/style\..*css$")


def _add_style(style: str, route: Route) -> None:
    """Let the page's own stylesheet end with more."""
    response = route.fetch()
    route.fulfill(response=response, body=response.text() + style)


@contextmanager
def closing_session(page: Page) -> Iterator[CDPSession]:
    session = page.context.new_cdp_session(page)
    try:
        yield session
    finally:
        session.detach()


@pytest.fixture
def reader(
    shown: LeaderboardSite, browser: Browser, record_property: Callable[[str, object], None]
) -> Iterator[Reader]:
    for reader in read_by(shown, browser):
        reader.note = record_property
        yield reader


@pytest.fixture
def plain_reader(shown: LeaderboardSite, browser: Browser) -> Iterator[Reader]:
    """One whose browser runs no scripts."""
    yield from read_by(shown, browser, java_script_enabled=False)


def read_by(shown: LeaderboardSite, browser: Browser, **settings: Any) -> Iterator[Reader]:
    context: BrowserContext = browser.new_context(**settings)
    reader = Reader(context.new_page(), shown.site.address)
    reader.page.on("console", lambda message: reader.problems.append(message.text))
    reader.page.on("pageerror", lambda error: reader.problems.append(str(error)))
    reader.page.on("request", lambda request: reader.requested_urls.append(request.url))
    yield reader
    assert [address for address in reader.requested_urls if not address.startswith(shown.site.address)] == []
    assert reader.problems == []
    assert context.cookies() == []
    context.close()


OPEN = "?split=tiny&language=en"
ADDRESSES = (
    f"/en/{OPEN}",
    "/hi/?split=open&language=both",
    "/hi/?split=hidden&language=en",
    f"/en/runs/{OPEN_RUN}",
    f"/hi/runs/{HIDDEN_RUN}",
    f"/hi/runs/{PRIVILEGED_RUN}",
    f"/en/runs/{OPEN_RUN}/episodes/quokka-0",
)


def agents(page: Page) -> list[str]:
    return page.locator("#standings tbody:first-of-type th[scope=row] bdi").all_inner_texts()[::2]


def test_sorting_by_keyboard_keeps_the_focus(reader: Reader) -> None:
    page = reader.open(f"/en/{OPEN}")
    assert agents(page) == ["best", "middle", "worst", "seer"]
    reader.press_until('a[data-swap="agent"]')
    page.keyboard.press("Enter")
    expect(page.locator('th[aria-sort="ascending"]')).to_contain_text("Agent")
    assert agents(page) == ["best", "middle", "seer", "worst"]
    assert page.evaluate("document.activeElement.dataset.swap") == "agent"
    page.keyboard.press("Enter")
    expect(page.locator('th[aria-sort="descending"]')).to_contain_text("Agent")
    assert agents(page) == ["worst", "seer", "middle", "best"]
    page.go_back()
    expect(page.locator('th[aria-sort="ascending"]')).to_contain_text("Agent")
    assert page.url.endswith("&sort=agent")


def test_the_latest_of_two_clicks_counts(reader: Reader) -> None:
    """The answer to the first one comes after that to the second."""
    page = reader.open("/en/")
    held: list[Route] = []
    page.route("**/*sort=agent*", lambda route: held.append(route))
    page.click('a[data-swap="agent"]')
    page.click('a[data-swap="published"]')
    expect(page.locator("th[aria-sort] a")).to_have_attribute("data-swap", "published")
    with page.expect_event("requestfinished", lambda request: "sort=agent" in request.url):
        held[0].continue_()
    page.evaluate("fetch('/en/').then((response) => response.text())")  # by then the page has read the late answer
    expect(page.locator("th[aria-sort] a")).to_have_attribute("data-swap", "published")
    assert "sort=published" in page.url


def test_filtering_works_by_keyboard(reader: Reader) -> None:
    page = reader.open(f"/en/{OPEN}")
    reader.press_until('select[name="sensors"]')
    page.keyboard.press("p")  # further letters count as another search if they come too late
    expect(page.locator('select[name="sensors"]')).to_have_value("privileged")
    reader.press_until("form button")
    page.keyboard.press("Enter")
    expect(page.get_by_text("Runs shown: 1 of 4.")).to_be_visible()
    assert agents(page) == ["seer"]
    assert page.evaluate("document.activeElement.dataset.swap") == "show"
    expect(page.locator("#said")).to_have_text("Runs on tiny, English: Both turns")


def test_sorting_filtering_and_links_work_without_scripts(plain_reader: Reader) -> None:
    page = plain_reader.open("/en/")
    page.select_option('select[name="split"]', "tiny")
    page.click("form button")
    expect(page).to_have_url(re.compile("[?&]split=tiny"))
    page.click('a[data-swap="agent"]')
    expect(page.locator('th[aria-sort="ascending"]')).to_contain_text("Agent")
    assert agents(page) == ["best", "middle", "seer", "worst"]
    page.select_option('select[name="coverage"]', "partial")
    page.click("form button")
    page.click("text=Show all runs")
    expect(page.locator("#standings tbody:first-of-type tr")).to_have_count(4)
    expect(page.locator('th[aria-sort="ascending"]')).to_contain_text("Agent")
    page.click("text=seer")
    expect(page.locator("h1")).to_have_text("seer: tiny, English")


def test_episode_is_opened_by_the_search_on_its_run_page(reader: Reader) -> None:
    page = reader.open(f"/en/runs/{OPEN_RUN}")
    page.get_by_label("Another episode").fill("quokka-2")
    page.keyboard.press("Enter")
    expect(page.locator("h1")).to_have_text("Episode quokka-2: truth")
    expect(page.get_by_role("img")).to_have_count(6)  # two maps and two rooms, a frame and its map


def test_the_first_tab_skips_to_the_content(reader: Reader) -> None:
    page = reader.open("/hi/")
    page.keyboard.press("Tab")
    expect(page.locator(":focus")).to_have_text("सीधे मुख्य सामग्री पर जाएँ")
    expect(page.locator(":focus")).to_be_in_viewport()
    page.keyboard.press("Enter")
    expect(page.locator("#content")).to_be_focused()


def test_the_language_is_switched_on_the_same_page(reader: Reader) -> None:
    page = reader.open(f"/en/{OPEN}&sort=ndtw")
    assert page.get_attribute("html", "lang") == "en"
    page.click('a[hreflang="hi"]')
    expect(page).to_have_url(f"{reader.site}/hi/{OPEN}&sort=ndtw")
    expect(page.locator("html")).to_have_attribute("lang", "hi")
    expect(page.locator("h1")).to_have_text("लीडरबोर्ड: tiny, अंग्रेज़ी")
    page.click('a[hreflang="en"]')
    expect(page).to_have_url(f"{reader.site}/en/{OPEN}&sort=ndtw")


def test_copy_button_copies_the_signature(shown: LeaderboardSite, reader: Reader) -> None:
    reader.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page = reader.open(f"/en/runs/{OPEN_RUN}")
    page.get_by_role("button", name="Copy").click()
    expect(page.get_by_role("button", name="Copied")).to_be_visible()
    assert page.evaluate("navigator.clipboard.readText()") == shown.board.entry(OPEN_RUN).signature


@pytest.mark.parametrize("address", ADDRESSES)
def test_a_phone_never_scrolls_sideways(reader: Reader, address: str) -> None:
    reader.page.set_viewport_size({"width": PHONE["width"], "height": PHONE["height"]})
    for page, font in reader.open_in_fonts(address):
        for details in page.locator("summary").all():
            details.click()
        assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"], font
        boxes = page.locator(".scroll").evaluate_all("boxes => boxes.map(box => box.getBoundingClientRect().right)")
        assert all(right <= PHONE["width"] for right in boxes), font


def test_phone_shows_rank_name_and_the_sorted_column(reader: Reader) -> None:
    reader.page.set_viewport_size({"width": PHONE["width"], "height": PHONE["height"]})
    for page, font in reader.open_in_fonts(f"/hi/{OPEN}"):
        box = page.locator(".board").bounding_box()
        assert box is not None
        for selector in ("tbody .rank", "tbody .name", "th[aria-sort]"):
            found = page.locator(selector).first.bounding_box()
            assert found is not None
            assert box["x"] <= found["x"], (selector, font)
            assert found["x"] + found["width"] <= box["x"] + box["width"], (selector, font)
        assert page.evaluate("document.querySelector('.board').scrollLeft") > 0, font


COVERED = """() => {
    const one = document.activeElement, box = one.getBoundingClientRect();
    return one.contains(document.elementFromPoint(box.left + 8, box.top + 8)) ? "" : one.outerHTML;
}"""


@pytest.mark.parametrize("size", [(360, 740), (720, 400), (1440, 800)])  # the second is a desktop at 200%
def test_focused_elements_are_not_covered(reader: Reader, size: tuple[int, int]) -> None:
    reader.page.set_viewport_size({"width": size[0], "height": size[1]})
    for page, font in reader.open_in_fonts(f"/en/{OPEN}"):
        page.locator('a[data-swap="published"]').focus()
        for key, last in (("Shift+Tab", 'a[data-swap="agent"]'), ("Tab", "#standings tbody tr:last-child a")):
            while not page.evaluate("last => document.activeElement.matches(last)", last):
                page.keyboard.press(key)
                assert page.evaluate(COVERED) == "", font


def test_focused_headers_scroll_out_from_under_pinned_columns(reader: Reader) -> None:
    reader.page.set_viewport_size({"width": PHONE["width"], "height": PHONE["height"]})
    for page, font in reader.open_in_fonts(f"/en/{OPEN}"):
        for name in ("ctc-3", "rpod", "published"):
            for covered in (2, 20, 45):  # pixels of it that are under the pinned columns
                page.locator(".board").focus()
                page.evaluate(
                    """([name, covered]) => {
                        const box = document.querySelector(".board");
                        const edge = box.querySelector("tbody .name").getBoundingClientRect().right;
                        const one = box.querySelector(`a[data-swap="${name}"]`);
                        box.scrollLeft += one.getBoundingClientRect().left - edge + covered;
                    }""",
                    [name, covered],
                )
                page.locator(f'a[data-swap="{name}"]').focus()
                assert page.evaluate(COVERED) == "", (font, name, covered)


def test_right_to_left_names_are_aligned_like_others(web: LeaderboardSite, browser: Browser) -> None:
    web.published(1, 0.5, "سامع", participant="مختبر")
    for reader in read_by(web, browser):
        names = reader.open(f"/en/{OPEN}").locator("#standings tbody th bdi")
        assert names.evaluate_all("all => all.map(one => getComputedStyle(one).textAlign)") == ["left", "left"]
        run = reader.open(f"/en/runs/{1:032x}")
        expect(run.locator("h1")).to_have_text("سامع: tiny, English")
        assert run.locator("h1 bdi").all_inner_texts() == ["سامع"]


def test_a_wide_screen_shows_all_columns_and_keeps_their_headings(reader: Reader) -> None:
    reader.page.set_viewport_size({"width": 1280, "height": 400})
    for language in ("en", "hi"):
        page = reader.open(f"/{language}/{OPEN}")
        assert page.evaluate("document.documentElement.scrollWidth") == 1280
        page.locator("#standings tbody tr").last.evaluate("row => row.scrollIntoView({block: 'start'})")
        heading = page.locator("#standings thead th").first.bounding_box()
        assert heading is not None
        assert heading["y"] == 0


def test_printed_page_shows_the_whole_table_without_forms(reader: Reader) -> None:
    reader.page.set_viewport_size({"width": 700, "height": 500})
    page = reader.open(f"/en/{OPEN}")
    page.emulate_media(media="print")
    assert not page.locator("form").is_visible()
    style = "one => [getComputedStyle(one).overflowX, getComputedStyle(one).maxHeight]"
    assert page.locator(".board").evaluate(style) == ["visible", "none"]
    positions = "all => [...new Set(all.map(one => getComputedStyle(one).position))]"
    assert page.locator("#standings th, #standings td, .stay").evaluate_all(positions) == ["static"]


def test_maps_are_clipped_to_their_frame(reader: Reader) -> None:
    page = reader.open(f"/en/runs/{OPEN_RUN}/episodes/quokka-0")
    assert (
        page.locator(".map").evaluate_all("maps => maps.map(one => getComputedStyle(one).overflow)") == ["hidden"] * 4
    )


def test_column_headers_are_named_by_their_columns_only(reader: Reader) -> None:
    page = reader.open(f"/en/{OPEN}")
    names = ["Rank", "Agent", "nDTW", "CTC-0", "CTC-3", "CTC-5", "CTC-7", "rPOD", "PTC"]
    for name in [*names, "Sensors", "Coverage", "Published"]:
        expect(page.get_by_role("columnheader", name=name, exact=True)).to_have_count(1)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("address", ADDRESSES)
def test_text_contrast_is_sufficient_in_both_colour_schemes(reader: Reader, address: str, scheme: Any) -> None:
    reader.page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
    page = reader.open(address)
    for details in page.locator("summary").all():
        details.click()
    contrasts = page.evaluate(CONTRASTS)
    assert len(contrasts) > 40
    assert [(round(ratio, 2), text) for ratio, text in contrasts if ratio < 4.5] == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_focus_outline_is_visible(reader: Reader, scheme: Any) -> None:
    reader.page.emulate_media(color_scheme=scheme)
    page = reader.open(f"/en/{OPEN}")
    for selector in ('a[data-swap="ptc"]', "div.scroll", 'select[name="split"]'):
        reader.press_until(selector)
        style = page.locator(selector).evaluate(
            "one => [getComputedStyle(one).outlineStyle, getComputedStyle(one).outlineWidth]"
        )
        assert style == ["solid", "3px"], selector


@pytest.mark.parametrize("address", ADDRESSES)
def test_interactive_elements_have_accessible_names(reader: Reader, address: str) -> None:
    page = reader.open(address)
    tree = page.locator("body").aria_snapshot()
    for role in ("link", "button", "combobox", "textbox", "region", "table", "img"):
        assert not [line for line in tree.splitlines() if line.strip() in (f"- {role}", f"- {role}:")], role

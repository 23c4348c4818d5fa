"""Writing in Chromium: by keyboard alone, with an input method, through reloads, a second window and a lost server."""

import re
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, Route, expect

from arramon_collecting.web.access import cookie_name
from tests.collecting.web.writing.write_site import OTHER_EDITOR, TEXTS, Writer, WriteSite
from tests.web.test_browser import CONTRASTS, PHONE

STREET_1, STREET_2 = ["ArrowUp", "ArrowUp"], ["ArrowUp", "ArrowUp", "ArrowUp"]
"""Keys that lead to the end of the line; the second one begins with a turn to face it."""


@contextmanager
def window(browser: Browser, writer: Writer, *, losing: bool = False, **settings: object) -> Iterator[BrowserContext]:
    """A browser in which a writer is signed in. Nothing may go wrong in it, unless its connection is to be lost."""
    context: BrowserContext = browser.new_context(**settings)  # type: ignore[arg-type]
    context.add_cookies(
        [{"name": cookie_name(writer.collection.name), "value": writer.cookie, "url": writer.site.site}]
    )
    problems: list[str] = []
    context.on("console", lambda message: problems.append(message.text))
    context.on("weberror", lambda error: problems.append(str(error.error)))
    yield context
    context.close()
    assert losing or problems == []


def opened(context: BrowserContext, writer: Writer, language: str = "en") -> Page:
    """The page of the writer's task, once its first view is shown."""
    page = context.new_page()
    page.goto(writer.site.site + writer.page.replace("/en/", f"/{language}/"))
    expect(page.locator("html")).to_have_attribute("data-at", re.compile("."))
    return page


def press(page: Page, *keys: str) -> None:
    """Press keys, and wait for the view after each."""
    for key in keys:
        before = page.get_attribute("html", "data-at")
        page.keyboard.press(key)
        expect(page.locator("html")).not_to_have_attribute("data-at", before or "")


def saved(page: Page, word: str = "Saved") -> None:
    expect(page.locator("#saved")).to_have_text(word)


def test_a_whole_task_by_keyboard_alone(browser: Browser, site: WriteSite) -> None:
    writer = site.writer()
    with window(browser, writer, losing=True) as context:  # What comes after the submission is another page's.
        page = opened(context, writer)
        for text, walk in zip(TEXTS, (STREET_1, [], STREET_2, []), strict=True):
            page.keyboard.press("Enter")
            expect(page.locator("#text")).to_be_focused()
            page.keyboard.type(text)  # Its letters walk nowhere.
            page.keyboard.press("Escape")
            expect(page.locator("#view")).to_be_focused()
            press(page, *walk, "Space")
        assert page.get_attribute("html", "data-at") == "3.1.0.2.0.4"
        expect(page.locator("#outcome")).to_contain_text("That was the last one.")
        expect(page.locator("#where")).to_be_hidden()
        expect(page.locator("#act")).to_have_text("Place it")
        saved(page)
        for _ in range(30):
            page.keyboard.press("Tab")
            if page.evaluate("document.activeElement.id") == "submit":
                break
        page.keyboard.press("Enter")
        page.wait_for_url(re.compile(f"/en/collect/{writer.collection.name}/[?]notice=sent$"))
    (found,) = site.store.texts.all(writer.collection.name)
    assert found.instructions == ((TEXTS[0], TEXTS[1]), (TEXTS[2], TEXTS[3]))
    assert found.evidence == {}


def test_walking_keys_walk_from_anywhere_outside_a_text(browser: Browser, site: WriteSite) -> None:
    writer = site.writer()
    with window(browser, writer) as context:
        page = opened(context, writer)
        expect(page.locator("#status")).to_be_hidden()
        expect(page.locator("#target")).to_have_text("striped red mug")
        summary = page.locator("#guidelines summary")
        expect(page.locator("#guidelines")).not_to_have_attribute("open", re.compile(""))
        for key in ("Space", "Space"):  # It opens and folds the guidelines, and picks up nothing.
            summary.press(key)
        press(page, "ArrowUp")
        expect(page.locator("#view")).to_be_focused()
        summary.focus()
        page.keyboard.press("Escape")
        expect(page.locator("#view")).to_be_focused()


@pytest.mark.parametrize(
    ("bend", "said", "flash"),
    [
        ("90 90 first", "The way begins with a turn: it turns to the right.", "You turned right"),
        (
            "-90 90 first",
            "first to the left. Together they are one turn to the right",
            "You turned left",
        ),
        (
            "180 90 later",
            "just after another turn. Together they are one turn to the right",
            "You turned around",
        ),
        ("30 0 first", "The line only sways a little here: it leads straight on.", ""),
    ],
)
def test_bends_that_follow_each_other_are_told_together(
    browser: Browser, site: WriteSite, bend: str, said: str, flash: str
) -> None:
    """The tiny street has no such line: the answer to one move is that of a line that has."""
    writer = site.writer()

    def turn(route: Route) -> None:
        answer = route.fetch()
        route.fulfill(
            response=answer, headers={**answer.headers, "arramon-bend": bend, "arramon-outcome": "faced_line"}
        )

    with window(browser, writer) as context:
        page = opened(context, writer)
        page.route(re.compile("/view[?].*move="), turn)
        page.focus("#view")
        page.keyboard.press("ArrowUp")
        expect(page.locator("#outcome")).to_contain_text(said)
        expect(page.locator("#flash")).to_have_text(re.compile(f"{flash}$"))


def test_words_at_fault_are_marked_and_block(browser: Browser, site: WriteSite) -> None:
    writer = site.writer()
    with window(browser, writer) as context:
        page = opened(context, writer)
        page.fill("#text", "Walk two steps and (then) pick up the striped red mug <i>now</i>.")
        expect(page.locator("#marked mark.blocked")).to_have_text(["steps", "(", ")"])
        expect(page.locator("#findings .blocked").first).to_contain_text("Please correct:")
        expect(page.locator("#findings")).to_contain_text("“steps” counts paces or turns.")
        expect(page.locator("#marked")).to_contain_text("<i>now</i>")
        page.locator("#findings button").first.click()
        assert page.evaluate("document.getSelection().toString()") in ("(", "steps")
        expect(page.locator("#parts button").first).to_have_attribute("data-state", "blocked")


@pytest.mark.parametrize(
    ("language", "fits", "fits_in_length"),
    [
        ("en", "Your text now fits: nothing in it must be corrected.", "The length of your text now fits."),
        ("hi", "अब आपका निर्देश ठीक है: इसमें कुछ सुधारना ज़रूरी नहीं।", "अब आपके निर्देश की लंबाई ठीक है।"),
    ],
)
def test_a_text_that_now_fits_is_told_so(
    browser: Browser, site: WriteSite, language: str, fits: str, fits_in_length: str
) -> None:
    writer = site.writer()
    counted = f"{TEXTS[0]} Walk two steps."
    with window(browser, writer) as context:
        page = opened(context, writer, language)
        news = page.locator("#news")
        expect(news).to_have_attribute("role", "status")
        for text, told, faults in (
            ("Walk.", "", 1),
            (TEXTS[0], fits, 0),
            ("a" * 10_001, "", 0),  # so long that it is not even saved, and not checked
            (TEXTS[0], fits, 0),
            (f"{counted} {TEXTS[1]} {TEXTS[2]}", "", 1),  # more than the 200 characters of this collection
            (counted, fits_in_length, 1),
            (TEXTS[0], fits, 0),
        ):
            page.fill("#text", text)
            expect(news).to_have_text(told)
            expect(page.locator("#findings .blocked")).to_have_count(faults)


def test_what_is_missing_is_said_before_submitting(browser: Browser, site: WriteSite) -> None:
    writer = site.writer()
    writer.open(OTHER_EDITOR)
    typed = (TEXTS[0], "", "Walk on, press a key and take it.", TEXTS[3])
    writer.post("/draft", writer.written(typed, editor=OTHER_EDITOR, revision=1))
    with window(browser, writer) as context:
        page = opened(context, writer)
        page.click("#submit")
        expect(page.locator("#parts [aria-current]")).to_contain_text("1. Room")
        expect(page.locator("#status")).to_have_text("This text is not written yet.")
        expect(page.locator("#text")).to_be_focused()
        page.fill("#text", TEXTS[1])
        saved(page)
        page.click("#submit")
        expect(page.locator("#parts [aria-current]")).to_contain_text("2. Street")
        expect(page.locator("#status")).to_have_text("Please correct what is marked first.")
    assert site.store.texts.all(writer.collection.name) == []


def test_nothing_happens_while_an_input_method_composes(browser: Browser, site: WriteSite) -> None:
    writer = site.writer("hi")
    with window(browser, writer) as context:
        page = opened(context, writer, "hi")
        page.focus("#text")
        sent: list[str] = []
        page.on("request", lambda request: sent.append(f"{request.method} {request.url}"))
        session = context.new_cdp_session(page)
        sentence = "सीधे चलें और वहाँ रखा हुआ लाल मग उठा लें"
        for typed in ("स", "सी", sentence):
            end = {"selectionStart": len(typed), "selectionEnd": len(typed)}
            session.send("Input.imeSetComposition", {"text": typed, **end})
        page.wait_for_timeout(1200)  # longer than the pause before a save
        expect(page.locator("#count")).to_contain_text("0 अक्षर")
        expect(page.locator("#findings li")).to_have_count(0)
        assert [one for one in sent if one.startswith("POST")] == []
        assert page.get_attribute("html", "data-at") == "0.0.0.2.0.0"
        session.send("Input.insertText", {"text": sentence})
        saved(page, "सहेजा गया")
        expect(page.locator("#count")).to_contain_text(f"{len(sentence)} अक्षर")
    body = site.store.drafts.get(writer.task.task_id).body
    assert body["texts"][0] == sentence
    assert (body["evidence"]["insertions"], body["evidence"]["pastes"]) == (0, 0)


def test_evidence_counts_what_was_not_typed(browser: Browser, site: WriteSite) -> None:
    writer = site.writer()
    with window(browser, writer) as context:
        page = opened(context, writer)
        page.focus("#text")
        page.keyboard.type("Walk on. ")
        page.evaluate(
            """() => {
              const data = new DataTransfer();
              data.setData("text", "pasted words");
              document.getElementById("text").dispatchEvent(new ClipboardEvent("paste", { clipboardData: data }));
            }"""
        )
        page.keyboard.insert_text("A sentence that comes all at once from somewhere else.")
        saved(page)
    evidence = site.store.drafts.get(writer.task.task_id).body["evidence"]
    assert [evidence[name] for name in ("pastes", "pasted_characters", "insertions")] == [1, 12, 1]


def test_a_second_window_takes_over_and_nothing_is_lost(browser: Browser, site: WriteSite) -> None:
    writer = site.writer()
    with window(browser, writer, losing=True) as context:
        first = opened(context, writer)
        first.fill("#text", TEXTS[0])
        saved(first)
        second = opened(context, writer)
        expect(second.locator("#text")).to_have_value(TEXTS[0])
        expect(first.locator("#status")).to_contain_text("written in another window")
        expect(first.locator("#text")).not_to_be_editable()
        second.fill("#text", TEXTS[2])
        saved(second)
        first.click("#again button")
        expect(first.locator("#text")).to_have_value(TEXTS[2])
        expect(second.locator("#status")).to_contain_text("written in another window")


def test_an_older_draft_of_a_browser_gets_the_newer_one_and_keeps_its_own_words(
    browser: Browser, site: WriteSite
) -> None:
    writer = site.writer()
    with window(browser, writer, losing=True) as context:
        page = opened(context, writer)
        context.set_offline(True)
        page.fill("#text", "What was typed without a connection.")
        expect(page.locator("#saved")).to_contain_text("Not saved")
        writer.open(OTHER_EDITOR)  # on another device
        revision = site.store.drafts.get(writer.task.task_id).revision
        assert writer.post("/draft", writer.written(editor=OTHER_EDITOR, revision=revision)).status == 200
        context.set_offline(False)
        expect(page.locator("#status")).to_contain_text("written in another window")
        page.reload()
        expect(page.locator("#text")).to_have_value(TEXTS[3])  # where the other device is
        expect(page.locator("#aside li")).to_have_text(["What was typed without a connection."])


def test_a_restarted_server_is_found_again(browser: Browser, tmp_path: Path) -> None:
    site = WriteSite(tmp_path)
    with closing(site.database):
        writer = site.writer()
        with window(browser, writer, losing=True) as context:
            page = opened(context, writer)
            site.kill()
            page.fill("#text", TEXTS[0])
            expect(page.locator("#saved")).to_contain_text("Not saved")
            page.focus("#view")
            page.keyboard.press("ArrowUp")
            expect(page.locator("#status")).to_contain_text("The connection was lost.")
            site.start()
            expect(page.locator("html")).to_have_attribute("data-at", "0.1.0.2.0.0")
            expect(page.locator("#status")).to_be_hidden()
            saved(page)
        assert site.store.drafts.get(writer.task.task_id).body["texts"][0] == TEXTS[0]
    assert site.stop() == 0


def test_buttons_on_a_phone(browser: Browser, site: WriteSite) -> None:
    writer = site.writer()
    with window(browser, writer, viewport=PHONE, has_touch=True, is_mobile=True) as context:
        page = opened(context, writer)
        for move in ("forward", "forward", "left", "back", "act"):
            button = page.locator(f'[data-move="{move}"]')
            box = button.bounding_box()
            assert box is not None
            assert min(box["width"], box["height"]) >= 44
        page.locator('[data-move="forward"]').tap()
        expect(page.locator("html")).to_have_attribute("data-at", "0.1.0.2.0.0")
        page.locator("#text").tap()
        expect(page.locator("[data-move='forward']")).to_be_hidden()
        page.locator("#view").tap()
        expect(page.locator("[data-move='forward']")).to_be_visible()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_contrast_and_width(browser: Browser, site: WriteSite, scheme: str) -> None:
    writer = site.writer("hi")
    with window(browser, writer, color_scheme=scheme, viewport=PHONE) as context:
        page = opened(context, writer, "hi")
        page.fill("#text", "नीली रेखा पर चलें, चाबी दबाएँ और बाएं रखा मग उठा लें।")
        expect(page.locator("#findings .blocked")).to_have_count(1)
        low = [(ratio, text) for ratio, text in page.evaluate(CONTRASTS) if ratio < 4.5]
        assert low == []
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]

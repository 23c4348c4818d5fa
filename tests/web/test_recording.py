"""Pages of a recording in Chromium: from a file, without a network, by keyboard, on a phone, in both languages."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client.agent import Episode, Observation
from arramon_client.recording.recorder import Recording
from tests.web.test_browser import CONTRASTS, PHONE

HOSTILE = (
    "</script><script>document.title = 'taken'</script><img src=http://localhost/x onerror=alert(1)> & \"so\" "
    "{{run}} {{data}}"
)

TEXTS = {"en": "Go on to the striped red mug.", "hi": "धारीदार लाल मग तक चलें।"}

ACTIONS = (0, 2, 0, 3, 0, 0, 3)
"""Of which the first four are in the street."""


def record(folder: Path, language: str, *, instruction: str = "", poses: bool = False) -> Path:
    """Records an episode of seven steps; returns the index."""
    run = pb.Run(run_id="r", agent=instruction or "mine", split="tiny", language=language)
    run.agent_arguments.add(name="beam", value="4")
    with Recording(folder, run, lambda _: None) as recording:
        recording.begin(Episode(instruction or "a 1", language, "tiny"))
        for step, action in enumerate(ACTIONS):
            recording.step(seen(step, instruction or TEXTS[language], instruction or "a 1", poses), action)
        recording.end(instruction or "a 1", types_pb2.CAUSE_AGENT_FINISHED)
    assert recording.error is None
    return recording.index


def seen(step: int, instruction: str, episode_id: str, poses: bool) -> Observation:
    outdoors = step < 4
    return Observation(
        episode_id=episode_id,
        turn=1,
        phase="navigation" if outdoors else "assembly",
        step=step,
        instruction=instruction,
        phase_step=step if outdoors else step - 4,
        steps_left=150 - step,
        rgb=np.full((32, 32, 3), 10 * step, np.uint8),
        depth=np.full((32, 32), step, np.float32),
        pose=(float(step), 0.0, 90.0) if poses else None,
    )


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """A page without a network, which must not ask for one, nor complain."""
    context = browser.new_context(offline=True, viewport={"width": 1280, "height": 900})
    page = context.new_page()
    problems: list[str] = []
    page.on("console", lambda message: problems.append(message.text))
    page.on("pageerror", lambda error: problems.append(str(error)))
    requested_urls: list[str] = []
    page.on("request", lambda request: requested_urls.append(request.url))
    yield page
    context.close()
    assert problems == []
    assert [url for url in requested_urls if not url.startswith(("file:", "data:"))] == []


def open_episode(page: Page, index: Path) -> None:
    page.goto(index.as_uri())
    page.get_by_role("link").click()
    expect(page.locator("#where")).not_to_be_empty()


@pytest.mark.parametrize(("language", "where", "action"), [
    ("en", ["Step 1 of 7", "Step 2 of 7", "Step 7 of 7"], ["forward", "right", "pick up / place"]),
    ("hi", ["क़दम 1 / 7", "क़दम 2 / 7", "क़दम 7 / 7"], ["आगे", "दाएँ", "उठाना / रखना"]),
])  # fmt: skip
def test_recording_is_navigated_by_keyboard(
    page: Page, tmp_path: Path, language: str, where: list[str], action: list[str]
) -> None:
    open_episode(page, record(tmp_path, language))
    assert page.locator("html").get_attribute("lang") == language
    expect(page.locator("#instruction")).to_have_text(TEXTS[language])
    for key, number in (("Home", 0), ("ArrowRight", 1), ("End", 2), ("PageDown", 0), ("PageUp", 2), ("Home", 0)):
        page.keyboard.press(key)
        expect(page.locator("#where")).to_have_text(where[number])
        expect(page.locator("#action")).to_have_text(action[number])
        assert page.locator("#step").get_attribute("aria-valuetext") == where[number]
    page.keyboard.press("Space")
    expect(page.locator("#where")).to_have_text(where[2])


def test_keys_on_slider_and_buttons_move_exactly_one_step(page: Page, tmp_path: Path) -> None:
    open_episode(page, record(tmp_path, "en"))
    page.locator("#step").focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#where")).to_have_text("Step 2 of 7")
    page.locator("#next").focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#where")).to_have_text("Step 3 of 7")
    page.keyboard.press("Space")  # Presses the button that has the focus.
    expect(page.locator("#where")).to_have_text("Step 4 of 7")


def test_each_step_has_its_own_pictures(page: Page, tmp_path: Path) -> None:
    open_episode(page, record(tmp_path, "en"))
    shown = []
    for _ in ACTIONS:
        for name in ("rgb", "depth"):
            image: Any = page.locator(f"#{name}")
            image.evaluate("image => image.decode()")
            assert image.evaluate("image => image.naturalWidth") == 32
            shown.append(image.get_attribute("src"))
        page.keyboard.press("ArrowRight")
    assert len(set(shown)) == 2 * len(ACTIONS)


@pytest.mark.parametrize(("poses", "street", "room"), [
    (False, "reckoned from the actions, not measured", "reckoned from the actions, with the walls"),
    (True, "the poses which the agent was shown", "the poses which the agent was shown"),
])  # fmt: skip
def test_map_names_the_source_of_its_poses(page: Page, tmp_path: Path, poses: bool, street: str, room: str) -> None:
    open_episode(page, record(tmp_path, "en", poses=poses))
    page.keyboard.press("ArrowRight")
    expect(page.locator("#map-text")).to_contain_text(street)
    past = page.locator("#map .past").get_attribute("points")
    assert past == ("0,0 1,0" if poses else "0,0 0,-1")
    page.keyboard.press("End")
    expect(page.locator("#map-text")).to_contain_text(room)
    assert page.locator("#map .grid").count() == 20


@pytest.mark.parametrize("language", ["en", "hi"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_recording_is_readable_on_a_phone(page: Page, tmp_path: Path, language: str, scheme: Any) -> None:
    page.set_viewport_size(PHONE)  # type: ignore[arg-type]
    page.emulate_media(color_scheme=scheme)
    index = record(tmp_path, language)
    page.goto(index.as_uri())
    for _ in range(2):
        assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
        low = [(ratio, text) for ratio, text in page.evaluate(CONTRASTS) if ratio < 4.5]
        assert low == []
        open_episode(page, index)
    assert min(box["height"] for box in (each.bounding_box() for each in page.get_by_role("button").all()) if box) >= 40


def test_server_texts_are_shown_as_plain_text(page: Page, tmp_path: Path) -> None:
    open_episode(page, record(tmp_path, "en", instruction=HOSTILE))
    expect(page.locator("#instruction")).to_have_text(HOSTILE)
    expect(page.locator("h1")).to_have_text(f"Episode {HOSTILE}")
    assert page.title() == f"Episode {HOSTILE} – ArraMon"
    assert page.locator("img").count() == 2


def test_recording_page_is_self_contained(page: Page, tmp_path: Path) -> None:
    index = record(tmp_path, "en")
    alone = tmp_path / "alone.html"
    next(index.parent.glob("*/index.html")).rename(alone)
    page.goto(alone.as_uri())
    expect(page.locator("#where")).to_have_text("Step 1 of 7")
    assert page.locator("#rgb").evaluate("image => image.decode().then(() => image.naturalWidth)") == 32

"""Faults between a real page and a real server: tampered, late and lost messages, floods, runs that ended elsewhere."""

import json
from collections.abc import Callable

import pytest
from playwright.sync_api import Browser, Page, WebSocketRoute, expect

from tests import forked, tiny
from tests.web.play.page_client import PageServer
from tests.web.play.test_play_in_browser import drawn, press, start, window

PIXELS = "document.getElementById('frame').toDataURL()"

KEEP_STATUSES = """() => {
    const status = document.getElementById("status");
    globalThis.statuses = [];
    new MutationObserver(() => statuses.push(status.textContent)).observe(status, { childList: true });
}"""
"""Keeps every text that the page's status shows."""

Message = str | bytes
Pass = Callable[[Message], None]


def tamper(
    page: Page,
    *,
    to_server: Callable[[Message, Pass], None] = lambda message, forward: forward(message),
    to_page: Callable[[Message, Pass], None] = lambda message, forward: forward(message),
) -> None:
    """Let functions see every message of the page's connections, and pass on what they like."""

    def connect(route: WebSocketRoute) -> None:
        server = route.connect_to_server()
        route.on_message(lambda message: to_server(message, server.send))
        server.on_message(lambda message: to_page(message, route.send))

    page.route_web_socket("**/play/socket", connect)


def test_tampered_messages_are_said_and_change_nothing(browser: Browser, server: PageServer) -> None:
    forged: list[Message] = []

    def insert(message: Message, forward: Pass) -> None:
        forward(message)
        said = json.loads(message)
        if said["type"] == "key" and said["step"] == 0:
            for changed in ({}, {"step": 7}, {"episode": "forged"}, {"action": 9}, {"type": "fly"}):
                forged.append(json.dumps({**said, **changed}))
                forward(forged[-1])
            forward("{")

    with window(browser, server) as page:
        answers: list[str] = []

        def note(message: Message, forward: Pass) -> None:
            if isinstance(message, str) and '"problem"' in message:
                answers.append(json.loads(message)["message"])
            forward(message)

        tamper(page, to_server=insert, to_page=note)
        start(page, server)
        page.evaluate(KEEP_STATUSES)
        press(page, (tiny.F,))
        # The answers come in any order, each in place of the one before.
        said = "That was not possible: episode 'forged': this stream has no such open"
        while not any(text.startswith(said) for text in page.evaluate("statuses")):
            page.wait_for_timeout(10)
        assert len(forged) == 5
        while len(answers) < 5:  # the repeated key is answered by its state
            page.wait_for_timeout(10)
        for part in ("step 7", "'forged'", "action is '9'", "'fly'", "not JSON"):
            assert any(part in answer for answer in answers), answers
        press(page, tiny.ACTIONS[1:3], first=1)
        expect(page.locator("#status")).to_be_hidden()
        expect(page.locator("#outcome")).to_have_text("You picked up: striped red mug")


AT_ONCE = """([codes, repeat]) => {
    for (const code of codes) {
        document.body.dispatchEvent(new KeyboardEvent("keydown", { code, repeat, bubbles: true }));
    }
}"""
"""Presses keys in one moment."""


def test_a_thousand_keys_in_one_moment_are_nine_steps(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        start(page, server)
        page.evaluate(AT_ONCE, [["ArrowLeft"] * 1000, False])
        drawn(page, 9)
        expect(page.locator("#outcome")).to_have_text(
            "You turned left. Further key presses that were not carried out: 991."
        )
        expect(page.locator("#flash")).to_have_text("Further key presses that were not carried out: 991.")
        press(page, (tiny.R,), first=9)
        expect(page.locator("#outcome")).to_have_text("You turned right.")
        expect(page.locator("#steps")).to_have_text("10")
        expect(page.locator("#heading")).to_have_text("120° from the start of this part")


def test_a_key_that_is_held_is_not_kept(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        start(page, server)
        page.evaluate(AT_ONCE, [["ArrowLeft"] * 1000, True])
        drawn(page, 1)
        press(page, (tiny.R,), first=1)
        expect(page.locator("#outcome")).to_have_text("You turned right.")
        expect(page.locator("#steps")).to_have_text("18")


@pytest.mark.parametrize(
    ("before", "keys", "step", "said"),
    [
        ((), ["ArrowUp", "ArrowUp", "Space", "ArrowUp", "ArrowUp"], 3, "You picked up: striped red mug"),
        ((), ["ArrowUp", "Space", "Space", "ArrowUp"], 2, "You picked up: striped red mug"),
        ((), ["Space", "ArrowUp", "ArrowLeft"], 1, "Nothing is within reach."),
        (
            (tiny.F, tiny.P, tiny.L),
            ["ArrowUp", "Space", "Space"],
            4,
            "You can step only while you face a wall straight: turn left or right first. The try cost a step.",
        ),
    ],
)
def test_keys_that_wait_are_dropped_where_their_place_changes(
    browser: Browser, server: PageServer, before: tuple[int, ...], keys: list[str], step: int, said: str
) -> None:
    with window(browser, server) as page:
        start(page, server)
        press(page, before)
        page.evaluate(AT_ONCE, [keys, False])
        drawn(page, step)
        for place in ("#outcome", "#flash"):
            text = f"{said} Further key presses that were not carried out: 2."
            expect(page.locator(place)).to_have_text(text)
        press(page, (tiny.L,), first=step)  # the next one counts at once
        expect(page.locator("#outcome")).to_have_text("You turned left.")


def test_keys_that_wait_are_dropped_when_the_connection_is_lost(browser: Browser, server: PageServer) -> None:
    """The first one, which was sent, counts; those behind it, and those pressed before the page is back, do not."""
    kept: list[WebSocketRoute] = []
    is_open = True

    def keys(message: Message, forward: Pass) -> None:
        if is_open:
            forward(message)

    with window(browser, server, losing=True) as page:

        def connect(route: WebSocketRoute) -> None:
            kept.append(route)
            behind = route.connect_to_server()
            route.on_message(lambda message: keys(message, behind.send))

        page.route_web_socket("**/play/socket", connect)
        start(page, server)
        is_open = False
        page.evaluate(AT_ONCE, [["ArrowUp", "ArrowLeft", "ArrowLeft"], False])
        page.route_web_socket("**/play/socket", lambda route: route.close())
        kept[0].close()
        expect(page.locator("#status")).to_contain_text("The connection was lost.")
        page.evaluate(AT_ONCE, [["ArrowRight"], False])
        is_open = True
        page.route_web_socket("**/play/socket", connect)
        drawn(page, 1)
        expect(page.locator("#outcome")).to_have_text(
            "You moved one step. Further key presses that were not carried out: 3."
        )
        press(page, (tiny.L,), first=1)
        expect(page.locator("#steps")).to_have_text("18")


def test_a_frame_that_arrives_after_the_next_key_is_not_shown(browser: Browser, server: PageServer) -> None:
    late: list[Message] = []

    def delay(message: Message, forward: Pass) -> None:
        if isinstance(message, bytes) and message[0] == 1:
            late.append(message)
            return
        forward(message)
        if isinstance(message, bytes) and message[0] == 2:
            forward(late[0])

    with window(browser, server) as page:
        tamper(page, to_page=delay)
        start(page, server)
        page.keyboard.press("ArrowRight")
        expect(page.locator("#steps")).to_have_text("19")
        page.keyboard.press("ArrowRight")
        drawn(page, 2)
        shown = page.evaluate(PIXELS)
        press(page, (tiny.L, tiny.R), first=2)
        assert len(late) == 1
        assert page.evaluate(PIXELS) == shown


def test_a_half_open_connection_is_left_and_the_key_counts_once(browser: Browser, server: PageServer) -> None:
    is_open = True

    def keys(message: Message, forward: Pass) -> None:
        nonlocal is_open
        if json.loads(message)["type"] == "hello":
            is_open = True
        forward(message)
        if '"step":1' in str(message).replace(" ", ""):
            is_open = False  # The key arrives, but no answer, and nobody closes the connection.

    with window(browser, server, losing=True) as page:
        page.clock.install()
        tamper(page, to_server=keys, to_page=lambda message, forward: forward(message) if is_open else None)
        start(page, server)
        press(page, (tiny.F,))
        page.keyboard.press("ArrowUp")
        for _ in range(100):
            page.clock.fast_forward(11_000)
            if page.locator("html").get_attribute("data-drawn") == "0 2":
                break
            page.wait_for_timeout(50)
        drawn(page, 2)
        press(page, (tiny.P,), first=2)
        expect(page.locator("#outcome")).to_have_text("You picked up: striped red mug")


def test_a_run_that_ended_elsewhere(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        start(page, server)
        press(page, (tiny.F,))
        run = page.evaluate("JSON.parse(localStorage.getItem('arramon-play')).current.en")
        done = forked.run("runs", "cancel", run, "--data", server.data)
        assert done.returncode == 0, done.stderr
        expect(page.locator("#status")).to_contain_text("The run has ended.")
        expect(page.locator("#start")).to_be_visible()
        page.reload()
        expect(page.locator("#start")).to_be_visible()
        start(page, server)


def test_a_forged_run_is_refused_and_forgotten(browser: Browser, server: PageServer) -> None:
    with window(browser, server) as page:
        page.goto(f"{server.site}/en/play")
        page.evaluate("""() => localStorage.setItem("arramon-play", JSON.stringify({
            player: "<b>", runs: "none", current: { en: "f".repeat(32) },
        }))""")
        page.reload()
        expect(page.locator("#status")).to_contain_text("The server does not know this run, or it is not yours:")
        start(page, server)
        press(page, (tiny.F,))

"""Scripted people of a simulated collection, each with a browser window and a link of their own."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from playwright.sync_api import Browser, BrowserContext, Error, Page, expect

from arramon_collecting.rules.screening import RIGHT_VERIFY, RIGHT_WRITE
from arramon_server.episodes.episode import Episode
from arramon_server.web.play.practice_split import practice_split
from benchmarks.collecting.host_server import HostServer

KEYS = ("ArrowUp", "ArrowLeft", "ArrowRight", "Space")
"""Keys of the actions: forward, left, right, pick up or place."""

KILL_AT_KEY, KILL_AT_SUBMIT = 0.002, 0.1
"""Probability of a kill after a key, and right after a submission was sent, while kills are left."""

PATIENCE = 60_000.0
"""Time in milliseconds that a person waits for a page, through a restart of the server."""

Texts = tuple[str, str, str, str]


@dataclass(kw_only=True)
class Person:
    """A worker or host.

    Attributes:
        link: their personal link.
        name: what they are called in the report.
        language: of the collection.
        tasks: number of tasks that they have submitted.
        mishaps: what went wrong in their window and was not foreseen.
    """

    server: HostServer
    browser: Browser
    name: str
    link: str
    language: str
    tasks: int = 0
    mishaps: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.context: BrowserContext = self.browser.new_context()
        self.context.set_default_timeout(PATIENCE)
        self.page: Page = self.context.new_page()
        self.page.on("dialog", lambda dialog: dialog.accept())
        self.page.on("pageerror", lambda error: self.mishaps.append(str(error)))
        self.go(self.link)
        self.home = "/".join(self.page.url.split("/")[:6])  # http://HOST/LANGUAGE/collect/NAME

    def go(self, address: str) -> None:
        """Open a page; again after the server was away."""
        for _ in range(3):
            try:
                self.page.goto(address)
                return
            except Error as error:
                if "ERR_CONNECTION" not in str(error) and "ERR_EMPTY_RESPONSE" not in str(error):
                    raise
        raise RuntimeError(f"{self.name}: {address} cannot be reached")

    def join(self) -> None:
        """Agree to the text of the collection."""
        if self.page.locator("[name=agree]").count():
            self.page.locator("[name=keep_texts][value=yes]").check()
            self.page.locator("[name=agree]").check()
            self.page.locator("form[action$=consent] button").click()
            self.page.wait_for_url(re.compile(r"/$|\?"))

    def take(self, stage: str) -> bool:
        """Take a task, passing the tests that come first; return whether there was one."""
        for _ in range(8):
            self.go(f"{self.home}/")
            going_on = self.page.locator(f"a.button[href*='/{stage}/']")
            button = self.page.locator(f"form[action$='/take']:has([name=stage][value={stage}]) button").last
            (going_on if going_on.count() else button).first.click()
            self.page.wait_for_load_state()
            at = self.page.url.removeprefix(self.home)
            if at.startswith(f"/{stage}/"):
                return True
            if at.startswith("/device"):
                self._measure()
            elif at.startswith("/screening"):
                self._answer(RIGHT_WRITE if stage == "write" else RIGHT_VERIFY)
            elif at.startswith("/placement"):
                self._place()
            else:
                return False
        raise RuntimeError(f"{self.name}: still at {self.page.url} after 8 pages")

    def _measure(self) -> None:
        self.page.wait_for_load_state("networkidle")  # until its script listens
        self.page.keyboard.press("ArrowUp")
        self.page.locator("#go-on a, #go-on button").click()
        self.page.wait_for_load_state()

    def _answer(self, right: Mapping[str, str]) -> None:
        for question, choice in right.items():
            self.page.locator(f"[name={question}][value={choice}]").check()
        self.page.locator("form button").last.click()
        self.page.wait_for_load_state()

    def _place(self) -> None:
        """Play the tutorial, whose last episode is the test. A killed server forgets it, so it is not killed here."""
        self.page.locator("#begin button").click()
        for lesson in practice_split().episodes.values():
            actions = [action for turn in lesson.turns for action in (*turn.actions, *turn.room_actions)]
            self._press(actions, episode=lesson.episode_id, kill_chance=0.0)
        self.page.locator("#go-on a, #go-on button").click()
        self.page.wait_for_load_state()

    def _press(
        self, actions: Sequence[int], first: int = 0, *, episode: str = "", kill_chance: float = KILL_AT_KEY
    ) -> None:
        """Press the key of each action once the frame before it is drawn."""
        for step, action in enumerate(actions, start=first):
            before = re.compile(rf"^{re.escape(episode) or '.*'} {step}$")
            expect(self.page.locator("html")).to_have_attribute("data-drawn", before, timeout=PATIENCE)
            self.page.keyboard.press(KEYS[action])
            self.server.maybe_kill(kill_chance)


@dataclass(kw_only=True)
class Writer(Person):
    """Writes for each episode what `say` returns, and submits it.

    Attributes:
        say: returns the four texts for the episode of a number that counts their tasks.
        pastes: whether the texts are pasted.
        leaves: whether the window is closed in the middle of the first task, for good.
        given_back: number of tasks that were given back, as the checks refused the text.
    """

    say: Callable[[int, str], Texts]
    pastes: bool = False
    leaves: bool = False
    has_left: bool = False
    given_back: int = 0

    def work(self, episode_of: Callable[[str], str]) -> bool:
        """Do one task; return whether there was one.

        Args:
            episode_of: returns the episode of a task's id; only scripted people ask.
        """
        if self.has_left or not self.take("write"):
            return False
        texts = self.say(self.tasks, episode_of(self.page.url.rpartition("/")[2]))
        for number, text in enumerate(texts):
            self._walk(number)
            if self.leaves:
                self.has_left = True
                self.context.close()
                return True
            self._write(text)
            self.page.locator("#view").focus()
            self._move("Space")
        expect(self.page.locator("#saved")).to_have_text(re.compile("Saved|सहेजा गया"), timeout=PATIENCE)
        if self.page.locator("#parts button[data-state=blocked]").count():
            self._give_back()
            return True
        self._submit()
        self.tasks += 1
        return True

    def _give_back(self) -> None:
        """Give back a task whose text the checks refuse."""
        self.go(f"{self.home}/")
        self.page.locator("form[action$='/return'] button").click()
        self.page.wait_for_load_state()
        self.given_back += 1

    def _walk(self, number: int) -> None:
        """Walk to the end of the line; in the room stay."""
        at = re.compile(rf"^{number}\.")
        expect(self.page.locator("html")).to_have_attribute("data-at", at, timeout=PATIENCE)
        self.page.locator("#view").focus()
        while number % 2 == 0 and float(self.page.locator("#way").get_attribute("value") or 0) < 1:
            self._move("ArrowUp")

    def _move(self, key: str) -> None:
        before = self.page.get_attribute("html", "data-at") or ""
        self.page.keyboard.press(key)
        self.server.maybe_kill(KILL_AT_KEY)
        expect(self.page.locator("html")).not_to_have_attribute("data-at", before, timeout=PATIENCE)

    def _write(self, text: str) -> None:
        self.page.locator("#text").focus()
        if self.pastes:
            self.page.evaluate(
                """(text) => {
                  const data = new DataTransfer(), area = document.getElementById("text");
                  data.setData("text", text);
                  area.dispatchEvent(new ClipboardEvent("paste", { clipboardData: data }));
                  area.value = text;
                  area.dispatchEvent(new InputEvent("input", { inputType: "insertFromPaste", bubbles: true }));
                }""",
                text,
            )
        else:
            self.page.locator("#text").press_sequentially(text)

    def _submit(self) -> None:
        """Submit, through a kill that comes before the answer."""
        page = self.page.url
        self.page.locator("#submit").click(no_wait_after=True)
        self.server.maybe_kill(KILL_AT_SUBMIT)
        for _ in range(3):
            try:
                self.page.wait_for_url(lambda url: url != page, timeout=20_000)
                return
            except Error:
                self.page.locator("#submit").click(no_wait_after=True)
        raise RuntimeError(f"{self.name}: {page} cannot be submitted: {self.page.locator('#status').inner_text()}")


@dataclass(kw_only=True)
class Verifier(Person):
    """Follows texts by the reference actions of the episode that has them, whatever episode they are shown in.

    Attributes:
        known: episodes by the four texts.
        is_hasty: whether they give up at once in place of following.
    """

    known: Mapping[str, tuple[Episode, int]]
    is_hasty: bool = False
    gave_up: bool = False

    def work(self) -> bool:
        """Do one task; return whether there was one."""
        if not self.take("verify"):
            return False
        self.gave_up = False
        if self.page.locator("#done").is_hidden():
            self._follow()
        expect(self.page.locator("#done")).to_be_visible(timeout=PATIENCE)
        self._hand_in()
        self.tasks += 1
        return True

    def _follow(self) -> None:
        drawn = self.page.locator("html")
        expect(drawn).to_have_attribute("data-drawn", re.compile(r" \d+$"), timeout=PATIENCE)
        step = int((drawn.get_attribute("data-drawn") or " 0").rpartition(" ")[2])
        while not self.is_hasty and self.page.locator("#done").is_hidden():
            text = self.page.locator("#instruction").inner_text()
            actions = self._actions(text)
            if actions is None:
                self.mishaps.append(f"a text that nobody wrote: {text[:60]!r}")
                break
            self._press(actions, step)
            step += len(actions)
            done = self.page.locator("#done")
            changed = self.page.locator("#instruction").filter(has_not_text=text)
            try:
                expect(done.or_(changed).filter(visible=True).first).to_be_visible(timeout=10_000)
            except AssertionError:
                break  # The text led to nothing that can be picked up or placed.
        self.gave_up = self.page.locator("#done").is_hidden()
        if self.gave_up:
            self.page.locator("#give-up").click()

    def _actions(self, text: str) -> Sequence[int] | None:
        found = self.known.get(text)
        if found is None:
            return None
        episode, number = found
        turn = episode.turns[number // 2]
        return turn.room_actions if number % 2 else turn.actions

    def _hand_in(self) -> None:
        """Hand in, through a kill that comes before the answer."""
        page = self.page.url
        for _ in range(4):
            if self.gave_up:  # Then the page asks for a reason.
                self.page.locator("#flags [type=checkbox]").first.check()
            self.page.locator("#flags button").last.click(no_wait_after=True)
            self.server.maybe_kill(KILL_AT_SUBMIT)
            try:
                expect(self.page.locator("form[action$='/take']")).to_have_count(1, timeout=20_000)
                return
            except AssertionError:
                self.go(page)
        said = self.page.locator("main").inner_text()
        raise RuntimeError(f"{self.name}: {page} cannot be handed in; the page says {said!r}")


@dataclass(kw_only=True)
class HostPerson(Person):
    """Accepts every text in review."""

    def work(self) -> bool:
        """Accept one text; return whether there was one."""
        self.go(f"{self.home}/review?state=in_review")
        texts = self.page.locator("main a[href*='/review/']")
        if not texts.count():
            return False
        texts.first.click()
        self.page.locator("form[action$='/accept'] button").click()
        self.page.wait_for_load_state()
        self.tasks += 1
        return True

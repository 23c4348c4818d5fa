"""One machine reader's page: its WebSocket, which is opened again when it breaks, and its run."""

import asyncio
import contextlib
import json
import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import aiohttp

from benchmarks.people.page_state import KEYS, QUIET, Shown, outcome_text, say

ANSWER_SECONDS = 120.0
"""Time after which a press returns without an answer. The key stays sent, and counts once."""

FIRST_DELAY, LONGEST_DELAY = 0.3, 5.0
"""Seconds until the first and any later attempt to connect again."""

HEADER_BYTES = 4
"""Length of the header of a binary message: the step, 32 bits, little-endian."""

FINAL = frozenset(
    ("Replaced", "TakenOver", "NotFound", "Forbidden", "Unauthenticated", "OverQuota", "BadInput", "Conflict")
)
"""Codes with which the server closes a connection for good, as the page's script lists them."""


class PageConnection:
    """Plays one run as the page does. Keys are pressed one at a time.

    Args:
        site: URL of the server's pages.
        hello: the first message, without `run` and `new`.
        what: `run` or `new` of the first message.
        frames: folder for the frames.

    Attributes:
        shown: the latest state with its frame; None before the first.
        run: id of the run; empty until the server has opened it.
        over: why nothing more is played; empty while the run is open.
    """

    def __init__(self, site: str, hello: dict[str, Any], what: dict[str, Any], frames: Path) -> None:
        self._site = site
        self._hello = hello
        self._what = what
        self._frames = frames
        self._socket: aiohttp.ClientWebSocketResponse | None = None
        self._state: dict[str, Any] = {}
        self._pending: dict[str, Any] | None = None
        self._news: list[str] = []
        self._changed = asyncio.Condition()
        self._ended, self._episodes = 0, 0
        self.shown: Shown | None = None
        self.run = ""
        self.over = ""

    async def play(self) -> None:
        """Stay connected until the run is over, or the server refuses for good."""
        delay = FIRST_DELAY
        async with aiohttp.ClientSession() as session:
            while not self.over:
                try:
                    async with session.ws_connect(
                        f"{self._site}/play/socket", headers={"Origin": self._site}, heartbeat=20.0
                    ) as socket:
                        await socket.send_str(json.dumps({**self._hello, **self._what}))
                        self._socket = socket
                        async for message in socket:
                            await self._take(message)
                            delay = FIRST_DELAY
                            if self.over:
                                break
                except (aiohttp.ClientError, ConnectionError, TimeoutError):
                    pass
                finally:
                    self._socket = None
                if not self.over:
                    await asyncio.sleep(delay * random.uniform(0.75, 1.25))  # noqa: S311 - no secret
                    delay = min(2 * delay, LONGEST_DELAY)

    async def first(self) -> None:
        """Wait for the first frame, or for the end."""
        async with self._changed:
            await self._changed.wait_for(lambda: self.shown is not None or bool(self.over))

    async def press(self, letters: str) -> tuple[list[str], list[tuple[str, Shown]]]:
        """Press keys after the first frame, one by one, until one does what a person would look at first.

        Args:
            letters: of `KEYS`.

        Returns:
            A line of text for each key, and the states that they led to, each with a caption.
        """
        lines: list[str] = []
        passed: list[tuple[str, Shown]] = []
        for number, letter in enumerate(letters, start=1):
            if self.over or self.shown is None:
                break
            before = self.shown
            news = await self._press(letter)
            after = self.shown
            is_same_episode = after.at[0] == before.at[0]
            outcome = outcome_text(letter, after.state) if is_same_episode and after is not before else ""
            lines.append(f"{number}. {letter}: {' '.join(filter(None, [outcome, *news])) or 'no answer yet'}")
            if after is before:
                break
            passed.append((f"{number}. {letter}", after))
            if news or after.state["outcome"] not in QUIET or not is_same_episode:
                break
        if len(lines) < len(letters):
            lines.append(f"Not pressed: {letters[len(lines) :]}")
        return lines, passed

    async def _press(self, letter: str) -> Sequence[str]:
        """Press one key, wait for its frame, and return what the server said besides."""
        shown = self.shown
        assert shown is not None
        episode, step = shown.at
        self._news.clear()
        self._pending = {"type": "key", "episode": episode, "step": step, "action": int(KEYS[letter])}
        await self._send_pending()
        try:
            async with asyncio.timeout(ANSWER_SECONDS), self._changed:
                await self._changed.wait_for(lambda: self._pending is None or bool(self.over))
        except TimeoutError:
            return []
        return list(self._news)

    async def _send_pending(self) -> None:
        """Send the key that has no answer; without a connection it is sent when the next one is at its step."""
        if self._socket is not None and self._pending is not None:
            with contextlib.suppress(ConnectionError):
                await self._socket.send_str(json.dumps(self._pending))

    async def _take(self, message: aiohttp.WSMessage) -> None:
        if message.type is aiohttp.WSMsgType.BINARY:
            await self._take_frame(message.data)
            return
        if message.type is not aiohttp.WSMsgType.TEXT:
            return
        said = json.loads(message.data)
        match said["type"]:
            case "opened":
                self.run, self._what = said["run"], {"run": said["run"]}
                self._ended, self._episodes = said["ended"], said["episodes"]
            case "state":
                self._state = said
            case "phase_ended" if said["forced"]:
                self._news.append(say("step_limit"))
            case "episode_ended":
                self._ended = said["ended"]
                self._news.append(say("ended", cause=say(f"cause_{said['cause']}")))
                if self._ended < self._episodes:
                    self._news.append("The next episode begins.")
            case "problem":
                self._news.append(say("problem", message=said["message"]))
                await self._settle()
            case "run_ended":
                await self._end(f"The run has ended. Episodes: {said['ended']}.")
            case "closed" if said["code"] in FINAL:
                await self._end(f"The server has closed the run: {said['message']}")

    async def _take_frame(self, data: bytes) -> None:
        step = int.from_bytes(data[:HEADER_BYTES], "little")
        if step != self._state["step"]:
            return
        number = self._ended + 1
        frame = self._frames / f"episode{number:03}-step{step:04}.jpg"
        frame.write_bytes(data[HEADER_BYTES:])
        self.shown = Shown(self._state, frame, number, self._episodes)
        if self._pending and self.shown.at == (self._pending["episode"], self._pending["step"]):
            # The connection broke before the key arrived; had it arrived, this would be the next step.
            await self._send_pending()
            return
        await self._settle()

    async def _settle(self) -> None:
        async with self._changed:
            self._pending = None
            self._changed.notify_all()

    async def _end(self, reason: str) -> None:
        self.over = reason
        self._news.append(reason)
        await self._settle()

"""One WebSocket of the play page, between the browser's messages and the engine."""

import asyncio
import json
import logging
import time
from collections.abc import Sequence
from contextlib import nullcontext, suppress

from aiohttp import WSCloseCode, WSMessage, WSMsgType, web

from arramon_client.world import Action
from arramon_server.errors import ArraMonError, BadInput, Conflict, Unavailable
from arramon_server.image_threads import ImageThreads
from arramon_server.runs.accounts.callers import UNAUTHENTICATED, Caller
from arramon_server.runs.play.stream import Act, Stream
from arramon_server.runs.storage.records import Run
from arramon_server.web.page_texts import DEFAULT_LANGUAGE, PageTexts, all_texts
from arramon_server.web.play.browser_access import BrowserAccess
from arramon_server.web.play.page_sender import JPEG_QUALITY, Message, PageSender
from arramon_server.web.play.requests import (
    AskScores,
    GiveUp,
    Hello,
    Key,
    Look,
    Next,
    Publish,
    read_hello,
    read_request,
)
from arramon_server.web.play.socket_ground import PracticeGround, SocketGround

HELLO_SECONDS = 20.0
"""Time within which a new connection must send its first message."""

SEND_SECONDS = 30.0
"""Time within which a browser must take a message; a connection that is not read for so long is closed."""

SCORES_SECONDS = 600.0
"""Time for which the page of an ended run may ask for scores."""

REFUSED_MESSAGES = 50
"""Number of malformed messages after which a connection is closed."""

LOOK_SECONDS = 0.05
"""Interval between the views of one page: they cost as much as a step, but no step."""

ADMISSION_SECONDS = 2.0
"""Interval at which an open connection is authenticated again, when it gets a message."""

_log = logging.getLogger(__name__)


class PlaySocket:
    """Serves one WebSocket.

    Args:
        socket: the prepared WebSocket.
        request: the request that opened it.
        access: authenticates the person, and limits streams.
        ground: what is played on.
        practice: the tutorial, for pages that ask for it.
        threads: in which frames are compressed.
        sizes: image side lengths that a page may request.
    """

    def __init__(
        self,
        socket: web.WebSocketResponse,
        request: web.BaseRequest,
        access: BrowserAccess,
        ground: SocketGround,
        practice: PracticeGround,
        threads: ImageThreads,
        sizes: Sequence[int],
    ) -> None:
        self._socket = socket
        self._request = request
        self._access = access
        self._ground = ground
        self._practice = practice
        self._threads = threads
        self._sizes = sizes
        self._refused = 0

    async def serve(self) -> None:
        """Play until the run ends, the person leaves, or an error closes the connection, which the page is told."""
        try:
            await self._play()
            await self._socket.close()
        except ArraMonError as error:
            reason = {"type": "closed", "code": type(error).__name__, "message": str(error)}
            with suppress(ConnectionError, TimeoutError):
                async with asyncio.timeout(SEND_SECONDS):
                    await self._socket.send_str(json.dumps(reason, ensure_ascii=False))
                    await self._socket.close(code=WSCloseCode.POLICY_VIOLATION)
        except (ConnectionError, _Gone):
            pass
        except TimeoutError:
            _log.info("a play page did not take a message within %.0f seconds", SEND_SECONDS)

    async def _play(self) -> None:
        hello = read_hello(await self._first_text())
        if hello.size not in self._sizes:
            raise BadInput(f"size is {hello.size}, expected one of {', '.join(map(str, self._sizes))}")
        caller = await self._access.authenticate(self._request, hello.token)
        if hello.practice:  # Its journal has no accounts, and its runs count nowhere.
            self._ground, caller = await self._practice.ground(), UNAUTHENTICATED
        run = await asyncio.to_thread(self._ground.runs.find_or_create, caller, hello.run)
        stream, sender = self._stream(run, hello)
        reader = None
        try:
            counted = nullcontext() if hello.practice else self._access.count_stream(caller, run, stream.player)
            async with counted:
                reader = asyncio.create_task(self._read(stream, sender, caller))
                try:
                    self._ground.engine.join(stream)
                    await self._write(sender, hello.token)
                finally:
                    self._ground.engine.leave(stream)
            if sender.has_run_end and not reader.done():
                with suppress(TimeoutError):
                    async with asyncio.timeout(SCORES_SECONDS):
                        await self._write(sender, hello.token)
        finally:
            if reader is not None:
                reader.cancel()

    def _stream(self, run: Run, hello: Hello) -> tuple[Stream, PageSender]:
        def actions_of(episode_id: str) -> Sequence[Action]:
            session = stream.sessions.get(episode_id)
            return session.actions if session else ()

        sender = PageSender(
            run,
            self._threads,
            is_hidden=self._ground.runs.is_hidden(run),
            image_size=hello.size,
            actions_of=actions_of,
            texts=texts_of(run.language),
        )
        stream = Stream(
            run=run,
            player=hello.player,
            max_episodes=1,
            image_size=hello.size,
            images=f"jpeg{JPEG_QUALITY}-{hello.size}",
            history=False,
            adopt=True,
            transport=sender,
            is_interactive=True,
            pauses=hello.pauses,
        )
        return stream, sender

    async def _write(self, sender: PageSender, token: str) -> None:
        """Send messages until the stream ends.

        Raises:
            ArraMonError: the error that closed the stream.
        """
        again = time.monotonic() + ADMISSION_SECONDS
        while (message := await sender.next_message()) is not None:
            if time.monotonic() >= again:
                with suppress(Unavailable):  # A person who was admitted before stays so while the database is away.
                    await self._access.authenticate(self._request, token)
                again = time.monotonic() + ADMISSION_SECONDS
            async with asyncio.timeout(SEND_SECONDS):
                await self._send(message)
            sender.note_sent(message)
            self._ground.engine.wake()

    async def _send(self, message: Message) -> None:
        if isinstance(message, bytes):
            await self._socket.send_bytes(message)
        else:
            await self._socket.send_str(message)

    async def _first_text(self) -> str:
        try:
            async with asyncio.timeout(HELLO_SECONDS):
                return _text(await self._socket.receive())
        except TimeoutError:
            raise BadInput(f"no message came within {HELLO_SECONDS:.0f} seconds; expected `hello`") from None

    async def _read(self, stream: Stream, sender: PageSender, caller: Caller) -> None:
        """Pass the page's messages to the engine until the page is gone."""
        try:
            while True:
                await self._take(_text(await self._socket.receive()), stream, sender, caller)
                await stream.wait_for_space()
        except ArraMonError as error:
            sender.close(error)
        except _Gone:
            sender.close(None)

    async def _take(self, text: str, stream: Stream, sender: PageSender, caller: Caller) -> None:
        """Handle one message.

        Raises:
            BadInput: if too many messages were malformed.
        """
        try:
            match read_request(text):
                case Key() | GiveUp() | Look() | Next() if sender.has_run_end:
                    raise Conflict(f"run {stream.run.run_id!r} has ended; it takes no more actions")
                case Key(episode, step, action):
                    self._ground.engine.receive(stream, [Act(episode, step, action=action)])
                case GiveUp(episode):
                    self._ground.engine.receive(stream, [Act(episode, 0, forfeit="given up on the page")])
                case Look(episode, step, degrees):
                    sender.look(episode, step, degrees)
                    await asyncio.sleep(LOOK_SECONDS)
                case Next():
                    self._ground.engine.resume(stream)
                case AskScores(episode):
                    html, placed = await self._ground.scores.html(
                        caller, stream.run, episode, texts_of(stream.run.language)
                    )
                    sender.put({"type": "scores", "episode": episode, "html": html, "placed": placed})
                case Publish():
                    await asyncio.to_thread(self._ground.runs.publish, caller, stream.run)
                    sender.put({"type": "published", "run": stream.run.run_id})
        except ArraMonError as error:
            self._refused += 1
            if self._refused >= REFUSED_MESSAGES:
                raise BadInput(f"{REFUSED_MESSAGES} messages were refused, the last one because {error}") from error
            sender.put(
                {"type": "problem", "code": type(error).__name__, "message": str(error), "episode": "", "step": 0}
            )


class _Gone(Exception):
    """The browser has closed the connection, or is no longer there."""


def texts_of(language: str) -> PageTexts:
    """Return the texts of the pages in the language of a run, or in the default language."""
    return all_texts().get(language) or all_texts()[DEFAULT_LANGUAGE]


def _text(message: WSMessage) -> str:
    """Return the text of a message.

    Raises:
        BadInput: if it is binary.
        _Gone: if it is the end of the connection.
    """
    if message.type is WSMsgType.TEXT:
        return str(message.data)
    if message.type is WSMsgType.BINARY:
        raise BadInput("a message is binary, expected text")
    raise _Gone

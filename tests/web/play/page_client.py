"""A play page without a browser: a WebSocket that says what a page says, and a server with pages."""

import asyncio
import json
import ssl
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import aiohttp

from tests import tiny
from tests.ports import free_port
from tests.serving import Server

PLAYER = "a" * 16

LOOK = 1 << 31
"""Bit that marks a view in another heading."""


class PageServer(Server):
    """A server with pages, on tiny splits; it keeps the pages' port when it is started again.

    Attributes:
        site: address of its pages.
    """

    def __init__(
        self, data: Path, *more: str, log: Path | None = None, environment: Mapping[str, str] | None = None
    ) -> None:
        tiny.write(data)
        tiny.write(data, "secret", 3, hidden=True)
        port = free_port(holder=self)
        self.site = f"http://127.0.0.1:{port}"
        super().__init__(data, "127.0.0.1:0", "--web", f"127.0.0.1:{port}", *more, log=log, environment=environment)


class PageClient:
    """One connection.

    Attributes:
        frames: step and size of every frame that came, in order.
        looks: step and JPEG of every view in another heading.
    """

    def __init__(self, connection: aiohttp.ClientWebSocketResponse) -> None:
        self.connection = connection
        self.frames: list[tuple[int, int]] = []
        self.looks: list[tuple[int, bytes]] = []

    async def say(self, **message: object) -> None:
        await self.connection.send_str(json.dumps(message))

    async def hello(
        self, run: str = "", *, player: str = PLAYER, size: int = 224, token: str = "", **new: object
    ) -> None:
        fields: dict[str, object] = {"player": player, "size": size, "token": token}
        what = {"run": run} if run else {"new": {"split": "tiny", "language": "en", "episodes": 1, **new}}
        await self.say(type="hello", **fields, **what)

    async def key(self, state: dict[str, Any], action: int, *, step: int | None = None) -> None:
        await self.say(
            type="key", episode=state["episode"], step=state["step"] if step is None else step, action=action
        )

    async def look(self, state: dict[str, Any], degrees: int) -> bytes:
        """The view in another heading, as JPEG."""
        await self.say(type="look", episode=state["episode"], step=state["step"], degrees=degrees)
        assert (await self.until("look"))["degrees"] == degrees
        number = len(self.looks)
        await self.say(type="scores", episode="none")  # An answer that comes after the view.
        assert (await self.message())["type"] == "problem"
        ((step, jpeg),) = self.looks[number:]
        assert step == state["step"]
        return jpeg

    async def message(self) -> dict[str, Any]:
        """The next message; frames before it are noted."""
        while True:
            got = await self.connection.receive(timeout=120)
            if got.type is aiohttp.WSMsgType.BINARY:
                assert got.data[4:6] == b"\xff\xd8", "a frame is a JPEG"
                header = int.from_bytes(got.data[:4], "little")
                if header & LOOK:
                    self.looks.append((header - LOOK, got.data[4:]))
                else:
                    self.frames.append((header, len(got.data) - 4))
                continue
            assert got.type is aiohttp.WSMsgType.TEXT, got
            message: dict[str, Any] = json.loads(got.data)
            return message

    async def until(self, kind: str) -> dict[str, Any]:
        """The next message of a type; others before it are passed over, but for problems and the end."""
        while True:
            message = await self.message()
            if message["type"] == kind:
                return message
            assert message["type"] not in ("problem", "closed"), message

    async def is_closed(self) -> bool:
        return (await self.connection.receive(timeout=120)).type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED)

    async def play(self, actions: tuple[int, ...] = tiny.ACTIONS) -> list[dict[str, Any]]:
        """Plays every episode with the same actions until the run ends; returns all messages."""
        messages = []
        while True:
            message = await self.message()
            messages.append(message)
            if message["type"] == "state":
                await self.key(message, actions[message["step"] % len(actions)])
            if message["type"] in ("run_ended", "closed"):
                return messages


@asynccontextmanager
async def page(
    site: str, *, origin: str | None = None, encryption: ssl.SSLContext | bool = True
) -> AsyncIterator[PageClient]:
    headers = {"Origin": site if origin is None else origin}
    connector = aiohttp.TCPConnector(ssl=encryption)
    try:
        async with (
            aiohttp.ClientSession(connector=connector, connector_owner=False) as session,
            session.ws_connect(f"{site}/play/socket", headers=headers) as connection,
        ):
            yield PageClient(connection)
    finally:  # Otherwise the end of an encrypted connection is left to an event loop that ends first.
        await connector.close(abort_ssl=True)
        await asyncio.sleep(0)

"""Closes connections over which nothing whole is asked: who begins a request and never ends it holds an open file."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

from aiohttp import web
from aiohttp.typedefs import Handler

SILENT_SECONDS = 20.0
"""Without a whole request, after which a connection is closed."""


class Silence:
    """Knows when each connection of a server was last asked something."""

    def __init__(self) -> None:
        self._since: dict[object, float] = {}

    @web.middleware
    async def heard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """A middleware that notes each request; while it is answered its connection is not silent."""
        self._since[request.protocol] = float("inf")
        try:
            return await handler(request)
        finally:
            self._since[request.protocol] = time.monotonic()

    @asynccontextmanager
    async def ended(self, server: web.Server) -> AsyncIterator[None]:
        """Closes silent connections of a server while the block runs."""
        watching = asyncio.create_task(self._watch(server))
        try:
            yield
        finally:
            watching.cancel()
            with suppress(asyncio.CancelledError):
                await watching

    async def _watch(self, server: web.Server) -> None:
        while True:
            await asyncio.sleep(SILENT_SECONDS / 4)
            now = time.monotonic()
            self._since = {connection: self._since.get(connection, now) for connection in server.connections}
            for connection in server.connections:
                if now - self._since[connection] > SILENT_SECONDS:
                    connection.force_close()

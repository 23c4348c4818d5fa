"""Closes idle HTTP connections, so that clients that never complete a request do not use up file descriptors."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

from aiohttp import web
from aiohttp.typedefs import Handler

IDLE_SECONDS = 20.0
"""Time without a complete request after which a connection is closed."""


class IdleConnections:
    """Closes the connections of a server that have sent no complete request for `IDLE_SECONDS`."""

    def __init__(self) -> None:
        self._since: dict[object, float] = {}

    @web.middleware
    async def middleware(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Record the time of each request, as aiohttp middleware. A connection is busy while a request is handled."""
        self._since[request.protocol] = float("inf")
        try:
            return await handler(request)
        finally:
            self._since[request.protocol] = time.monotonic()

    @asynccontextmanager
    async def close_idle(self, server: web.Server) -> AsyncIterator[None]:
        """Close idle connections of a server while the block runs."""
        watcher = asyncio.create_task(self._watch(server))
        try:
            yield
        finally:
            watcher.cancel()
            with suppress(asyncio.CancelledError):
                await watcher

    async def _watch(self, server: web.Server) -> None:
        while True:
            await asyncio.sleep(IDLE_SECONDS / 4)
            now = time.monotonic()
            self._since = {connection: self._since.get(connection, now) for connection in server.connections}
            for connection in server.connections:
                if now - self._since[connection] > IDLE_SECONDS:
                    connection.force_close()

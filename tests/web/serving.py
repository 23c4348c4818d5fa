"""The pages on a free loopback port, in their own thread, and a plain HTTP client."""

import asyncio
import gzip
import http.client
import threading
from dataclasses import dataclass

from aiohttp import web

from arramon_server.web.pages import Pages


@dataclass(frozen=True)
class Got:
    """An answer: its body is decompressed; `size` is what came over the wire."""

    status: int
    headers: dict[str, str]
    body: bytes
    size: int

    @property
    def text(self) -> str:
        return self.body.decode()


class Site:
    """Serves `pages` until it is closed."""

    def __init__(self, pages: Pages) -> None:
        self._loop = asyncio.new_event_loop()
        self._pages = pages
        application = web.Application()
        application.add_routes(pages.routes())
        self._runner = web.AppRunner(application)
        self._thread = threading.Thread(target=self._loop.run_forever)
        self._thread.start()
        self.port: int = asyncio.run_coroutine_threadsafe(self._start(), self._loop).result(120)
        self.address = f"http://127.0.0.1:{self.port}"

    async def _start(self) -> int:
        await self._runner.setup()
        site = web.TCPSite(self._runner, "127.0.0.1", 0)
        await site.start()
        return int(self._runner.addresses[0][1])

    def close(self) -> None:
        asyncio.run_coroutine_threadsafe(self._runner.cleanup(), self._loop).result(120)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(120)
        self._loop.close()
        self._pages.close()

    def get(self, path: str, headers: dict[str, str] | None = None, method: str = "GET") -> Got:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        try:
            connection.request(method, path, headers=headers or {})
            response = connection.getresponse()
            body = response.read()
            found = {name.lower(): value for name, value in response.getheaders()}
        finally:
            connection.close()
        size = len(body)
        if found.get("content-encoding") == "gzip":
            body = gzip.decompress(body)
        return Got(response.status, found, body, size)

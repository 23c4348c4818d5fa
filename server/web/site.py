"""The web addresses of a server process: probes, metrics, and the pages beside them, on the event loop that plays."""

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, closing
from dataclasses import replace

from aiohttp import web

from server.config import Config
from server.errors import BadInput
from server.metrics import CONTENT_TYPE
from server.tls import context_of
from server.web.pages import Pages
from server.web.silence import Silence


class Site:
    """Answers over HTTP.

    Args:
        config: says where.
        problem: why the process is not ready; empty where it is.
        metrics: their text; not called on the event loop.
        pages: the leaderboard's; closed at the end.
    """

    def __init__(
        self,
        config: Config,
        problem: Callable[[], str],
        metrics: Callable[[], bytes],
        pages: Pages,
    ) -> None:
        self._config = config
        self._problem = problem
        self._metrics = metrics
        self._pages = pages

    @asynccontextmanager
    async def open(self) -> AsyncIterator[dict[str, str]]:
        """Serves while the block runs. Gives what is served where.

        Raises:
            BadInput: if an address cannot be listened on.
        """
        probes = [web.get("/healthz", self._alive), web.get("/readyz", self._ready)]
        measured = [web.get("/metrics", self._measure)]
        config = self._config
        web_address, metrics_address = config.web, config.metrics_address
        async with AsyncExitStack() as stack:
            stack.enter_context(closing(self._pages))
            if config.web:
                here = measured if config.metrics_address == config.web else []
                routes = [*probes, *here, *self._pages.routes()]
                web_address = await stack.enter_async_context(self._serving(config.web, routes))
                metrics_address = web_address if here else metrics_address
            if config.metrics_address != config.web and config.metrics_address:
                routes = [*probes, *measured]
                metrics_address = await stack.enter_async_context(self._serving(config.metrics_address, routes))
            yield replace(config, web=web_address, metrics=metrics_address).http

    @asynccontextmanager
    async def _serving(self, address: str, routes: Sequence[web.AbstractRouteDef]) -> AsyncIterator[str]:
        host, _, port = address.rpartition(":")
        silence = Silence()
        app = web.Application(middlewares=[silence.heard])
        app.add_routes(routes)
        # Signals are the server's own; what is asked of pages is not written down.
        runner = web.AppRunner(app, handle_signals=False, access_log=None, shutdown_timeout=1.0)
        await runner.setup()
        try:
            context = context_of(self._config)
            shared = self._config.shared_port or None
            try:
                site = web.TCPSite(runner, host.strip("[]"), int(port), ssl_context=context, reuse_port=shared)
                await site.start()
            except OSError as error:
                raise BadInput(f"cannot listen on {address!r}: {error.strerror}") from error
            assert runner.server is not None
            async with silence.ended(runner.server):
                yield f"{host}:{runner.addresses[0][1]}"
        finally:
            await runner.cleanup()

    async def _alive(self, _: web.Request) -> web.Response:
        return web.Response(text="alive\n")

    async def _ready(self, _: web.Request) -> web.Response:
        problem = self._problem()
        return web.Response(text=f"{problem or 'ready'}\n", status=503 if problem else 200)

    async def _measure(self, _: web.Request) -> web.Response:
        body = await asyncio.to_thread(self._metrics)
        return web.Response(body=body, headers={"Content-Type": CONTENT_TYPE})

"""HTTP server of a server process: probes, metrics and pages. It runs on the engine's event loop."""

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, closing
from dataclasses import replace

from aiohttp import web

from arramon_server.configuration.config import Config
from arramon_server.errors import BadInput
from arramon_server.process.prometheus_metrics import CONTENT_TYPE
from arramon_server.process.tls import http_tls_context
from arramon_server.web.idle_connections import IdleConnections
from arramon_server.web.pages import Pages


class HttpServer:
    """Serves probes, metrics and pages over HTTP.

    Args:
        config: settings with the addresses and the certificate.
        problem: returns why the process is not ready; empty if it is.
        metrics: returns the metrics in Prometheus's format; called in a thread, off the event loop.
        pages: the leaderboard's pages; closed at the end.
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
        """Serve while the block runs; yield the URLs of "pages" and "metrics" that are served.

        Raises:
            BadInput: if the process cannot listen on an address.
        """
        probes = [web.get("/healthz", self._alive), web.get("/readyz", self._ready)]
        metrics_routes = [web.get("/metrics", self._measure)]
        config = self._config
        web_address, metrics_address = config.web, config.metrics_address
        async with AsyncExitStack() as stack:
            stack.enter_context(closing(self._pages))
            if config.web:
                shared_routes = metrics_routes if config.metrics_address == config.web else []
                routes = [*probes, *shared_routes, *self._pages.routes()]
                web_address = await stack.enter_async_context(self._serving(config.web, routes))
                metrics_address = web_address if shared_routes else metrics_address
            if config.metrics_address != config.web and config.metrics_address:
                routes = [*probes, *metrics_routes]
                metrics_address = await stack.enter_async_context(self._serving(config.metrics_address, routes))
            yield replace(config, web=web_address, metrics=metrics_address).http

    @asynccontextmanager
    async def _serving(self, address: str, routes: Sequence[web.AbstractRouteDef]) -> AsyncIterator[str]:
        host, _, port = address.rpartition(":")
        idle_connections = IdleConnections()
        app = web.Application(middlewares=[idle_connections.middleware])
        app.add_routes(routes)
        # The process handles signals itself. Requests for pages are not logged.
        runner = web.AppRunner(app, handle_signals=False, access_log=None, shutdown_timeout=1.0)
        await runner.setup()
        try:
            context = http_tls_context(self._config)
            shared = self._config.shared_port or None
            try:
                site = web.TCPSite(runner, host.strip("[]"), int(port), ssl_context=context, reuse_port=shared)
                await site.start()
            except OSError as error:
                raise BadInput(f"cannot listen on {address!r}: {error.strerror}") from error
            assert runner.server is not None
            async with idle_connections.close_idle(runner.server):
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

"""The page of the practice and the placement test, which come before the first verification, and its WebSocket."""

from aiohttp import web

from arramon_collecting.storage.records import Collection
from arramon_collecting.verifying.placement_test import LESSONS, TEST_ALONE
from arramon_collecting.web.access import Visitor
from arramon_collecting.web.handlers import BASE, Handlers, request_texts
from arramon_collecting.web.verifying.verify_settings import play_settings
from arramon_collecting.web.verifying.verify_socket import VerifySockets
from arramon_server.errors import Conflict


class PlacementPage:
    """The page.

    Args:
        handlers: what all pages of collections share.
        sockets: serves the WebSocket.
    """

    def __init__(self, handlers: Handlers, sockets: VerifySockets) -> None:
        self._handlers = handlers
        self._sockets = sockets

    def routes(self) -> list[web.RouteDef]:
        """Return the routes."""
        guarded = self._handlers.guarded
        return [
            web.get(f"{BASE}/placement", guarded(self._show_placement)),
            web.get(f"{BASE}/placement/socket", guarded(self._serve_placement)),
        ]

    def close(self) -> None:
        """Do nothing: there is nothing to end."""

    async def _show_placement(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._visitor(request)
            lessons = TEST_ALONE if "repeat" in request.query else LESSONS
            settings = play_settings(
                request_texts(request),
                visitor,
                socket=f"{request.path}/socket",
                player=visitor.worker.worker_id,
                sizes=self._sockets.sizes,
            )
            context = {
                "settings": settings | {"isTest": True, "lessons": lessons},
                "repeat_address": f"{request.path}?repeat",
                "passed_questions": "passed" in request.query,
                "has_task": self._handlers.store.tasks.has_verify(collection, visitor.worker),
            }
            return self._handlers.page(request, "collect/placement.html", collection, context, visitor=visitor)

        return await self._handlers.run(make)

    async def _serve_placement(self, request: web.Request) -> web.StreamResponse:
        collection, visitor = await self._handlers.run(lambda: self._visitor(request))
        return await self._sockets.serve_placement(request, collection, visitor.worker)

    def _visitor(self, request: web.Request) -> tuple[Collection, Visitor]:
        collection, visitor = self._handlers.visitor(request)
        if visitor.worker.consented_at is None:
            raise Conflict("the test comes after the worker has agreed to the collection's text")
        return collection, visitor

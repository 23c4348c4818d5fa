"""The pages before the first verification: the screening test, and the placement test with its WebSocket."""

from typing import Any

from aiohttp import web

from arramon_collecting.rules.screening import Screening
from arramon_collecting.rules.verify_test import RIGHT_VERIFY
from arramon_collecting.storage.records import VERIFY, Collection
from arramon_collecting.verifying.placement_test import LESSONS, TEST_ALONE
from arramon_collecting.web.access import Visitor
from arramon_collecting.web.handlers import BASE, Handlers, home_address, request_texts, see_other
from arramon_collecting.web.screening_attempts import judge, screening_context, standing
from arramon_collecting.web.verify_settings import play_settings
from arramon_collecting.web.verify_socket import VerifySockets
from arramon_server.errors import Conflict


class VerifyTests:
    """Both tests.

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
            web.get(f"{BASE}/screening/verify", guarded(self._show_screening)),
            web.post(f"{BASE}/screening/verify", guarded(self._answer_screening)),
            web.get(f"{BASE}/placement", guarded(self._show_placement)),
            web.get(f"{BASE}/placement/socket", guarded(self._serve_placement)),
        ]

    def close(self) -> None:
        """Do nothing: there is nothing to end."""

    async def _show_screening(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._visitor(request)
            screening = standing(visitor, VERIFY)
            if screening.passed_at is not None:
                return see_other(home_address(request))
            return self._screening_page(request, collection, visitor, screening, ())

        return await self._handlers.run(make)

    async def _answer_screening(self, request: web.Request) -> web.StreamResponse:
        fields = await self._handlers.form(request)

        def make() -> web.Response:
            collection, visitor = self._visitor(request)
            self._handlers.check(request, visitor, fields)
            after, wrong = judge(self._handlers.store, collection, visitor, VERIFY, fields, RIGHT_VERIFY)
            if after.passed_at is not None:
                return see_other(f"{home_address(request)}placement?passed")
            return self._screening_page(request, collection, visitor, after, wrong)

        return await self._handlers.run(make)

    def _screening_page(
        self,
        request: web.Request,
        collection: Collection,
        visitor: Visitor,
        screening: Screening,
        wrong: tuple[str, ...],
    ) -> web.Response:
        context: dict[str, Any] = {
            **screening_context(self._handlers.store, collection, screening, wrong, RIGHT_VERIFY),
            "here_address": request.path,
        }
        return self._handlers.page(request, "collect/screening_verify.html", collection, context, visitor=visitor)

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
            }
            return self._handlers.page(request, "collect/placement.html", collection, context, visitor=visitor)

        return await self._handlers.run(make)

    async def _serve_placement(self, request: web.Request) -> web.StreamResponse:
        collection, visitor = await self._handlers.run(lambda: self._visitor(request))
        return await self._sockets.serve_placement(request, collection, visitor.worker)

    def _visitor(self, request: web.Request) -> tuple[Collection, Visitor]:
        collection, visitor = self._handlers.visitor(request)
        if visitor.worker.consented_at is None:
            raise Conflict("the tests come after the worker has agreed to the collection's text")
        return collection, visitor

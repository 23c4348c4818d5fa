"""The screening test before writing, `/LANGUAGE/collect/NAME/screening/write`: a form that needs no scripts."""

from contextlib import suppress
from typing import Any

from aiohttp import web

from arramon_collecting.rules.screening import RIGHT_WRITE, Screening
from arramon_collecting.storage.records import WRITE, Collection, Worker
from arramon_collecting.storage.workers import check_active
from arramon_collecting.web.access import Visitor
from arramon_collecting.web.handlers import BASE, Handlers, home_address, request_texts, see_other
from arramon_collecting.web.screening_attempts import judge, screening_context, standing
from arramon_collecting.web.task_claims import TaskClaims
from arramon_collecting.web.writing.guidelines import guidelines_context
from arramon_server.errors import Conflict, OverQuota

ADDRESS = f"{BASE}/screening/{WRITE}"


class WriteScreening:
    """The screening test before writing (paper, appendix "Qualification Tests").

    Args:
        handlers: what all pages of collections share.
        claims: gives out the task that the test was for.
    """

    def __init__(self, handlers: Handlers, claims: TaskClaims) -> None:
        self._handlers = handlers
        self._claims = claims

    def routes(self) -> list[web.RouteDef]:
        """Return the routes of the test."""
        guarded = self._handlers.guarded
        return [web.get(ADDRESS, guarded(self._ask)), web.post(ADDRESS, guarded(self._judge))]

    def close(self) -> None:
        """End nothing: the test holds nothing open."""

    async def _ask(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            found = standing(visitor, WRITE)
            if found.passed_at is not None:
                return see_other(home_address(request))
            return self._page(request, collection, visitor, found, ())

        return await self._handlers.run(make)

    async def _judge(self, request: web.Request) -> web.Response:
        fields = await self._handlers.form(request)

        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            self._handlers.check(request, visitor, fields)
            check_active(visitor.worker)
            found, wrong = judge(self._handlers.store, collection, visitor, WRITE, fields, RIGHT_WRITE)
            if found.passed_at is not None:
                worker = self._handlers.store.workers.get(visitor.worker.worker_id)
                return see_other(self._address_after(request, collection, worker))
            return self._page(request, collection, visitor, found, wrong)

        return await self._handlers.run(make)

    def _address_after(self, request: web.Request, collection: Collection, worker: Worker) -> str:
        """Return where a worker goes who has passed: to a task, or to their page if there is none now."""
        with suppress(Conflict, OverQuota):  # The collection pauses, say: the page tells what is the matter.
            if address := self._claims.address(request, collection, worker, WRITE):
                return f"{address}{'&' if '?' in address else '?'}passed"
        return f"{home_address(request)}?notice=passed_write"

    def _page(
        self,
        request: web.Request,
        collection: Collection,
        visitor: Visitor,
        found: Screening,
        wrong: tuple[str, ...],
    ) -> web.Response:
        context: dict[str, Any] = {
            **screening_context(self._handlers.store, collection, found, wrong, RIGHT_WRITE),
            **guidelines_context(request_texts(request), collection, is_open=True),
        }
        return self._handlers.page(request, "write/screening.html", collection, context, visitor=visitor)

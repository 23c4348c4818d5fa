"""The screening tests, `/LANGUAGE/collect/NAME/screening/STAGE`: forms that need no scripts."""

from contextlib import suppress
from typing import Any

from aiohttp import web

from arramon_collecting.rules.screening import RIGHT_ANSWERS, Screening
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.people.workers import check_active
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.work.records import VERIFY, WRITE
from arramon_collecting.web.access import Visitor
from arramon_collecting.web.handlers import BASE, Handlers, home_address, request_texts, see_other
from arramon_collecting.web.people.screening_attempts import judge, screening_context, standing
from arramon_collecting.web.people.task_claims import TaskClaims
from arramon_collecting.web.writing.guidelines import guidelines_context
from arramon_server.errors import Conflict, OverQuota

ADDRESS = f"{BASE}/screening/{{stage:{WRITE}|{VERIFY}}}"

RULES = {WRITE: "write/guidelines.html", VERIFY: "collect/verify_rules.html"}
"""Template of what a stage's questions are about, shown above them."""


class ScreeningPages:
    """The screening tests of both stages (paper, appendix "Qualification Tests").

    Args:
        handlers: what all pages of collections share.
        claims: gives out the task that the test was for, or what else is missing before it.
    """

    def __init__(self, handlers: Handlers, claims: TaskClaims) -> None:
        self._handlers = handlers
        self._claims = claims

    def routes(self) -> list[web.RouteDef]:
        """Return the routes of the tests."""
        guarded = self._handlers.guarded
        return [web.get(ADDRESS, guarded(self._ask)), web.post(ADDRESS, guarded(self._judge))]

    def close(self) -> None:
        """End nothing: the tests hold nothing open."""

    async def _ask(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            collection, visitor = self._visitor(request)
            found = standing(visitor, request.match_info["stage"])
            if found.passed_at is not None:
                return see_other(home_address(request))
            return self._page(request, collection, visitor, found, ())

        return await self._handlers.run(make)

    async def _judge(self, request: web.Request) -> web.Response:
        fields = await self._handlers.form(request)

        def make() -> web.Response:
            collection, visitor = self._visitor(request)
            self._handlers.check(request, visitor, fields)
            check_active(visitor.worker)
            stage = request.match_info["stage"]
            found, wrong = judge(self._handlers.store, collection, visitor, stage, fields, RIGHT_ANSWERS[stage])
            if found.passed_at is not None:
                worker = self._handlers.store.workers.get(visitor.worker.worker_id)
                return see_other(self._address_after(request, collection, worker))
            return self._page(request, collection, visitor, found, wrong)

        return await self._handlers.run(make)

    def _visitor(self, request: web.Request) -> tuple[Collection, Visitor]:
        collection, visitor = self._handlers.visitor(request)
        if visitor.worker.consented_at is None:
            raise Conflict("the tests come after the worker has agreed to the collection's text")
        return collection, visitor

    def _address_after(self, request: web.Request, collection: Collection, worker: Worker) -> str:
        """Return where a worker goes who has passed: to a task, or to their page if there is none now."""
        with suppress(Conflict, OverQuota):  # The collection pauses, say: the worker's page says so.
            if address := self._claims.address(request, collection, worker, request.match_info["stage"]):
                return f"{address}{'&' if '?' in address else '?'}passed"
        return f"{home_address(request)}?notice=passed"

    def _page(
        self,
        request: web.Request,
        collection: Collection,
        visitor: Visitor,
        found: Screening,
        wrong: tuple[str, ...],
    ) -> web.Response:
        stage = request.match_info["stage"]
        context: dict[str, Any] = {
            "group": f"collect_screening_{stage}",
            "rules": RULES[stage],
            "has_task": stage != VERIFY or self._handlers.store.tasks.has_verify(collection, visitor.worker),
            **screening_context(self._handlers.store, collection, found, wrong, RIGHT_ANSWERS[stage]),
            **guidelines_context(request_texts(request), collection, is_open=True),
        }
        return self._handlers.page(request, "collect/screening.html", collection, context, visitor=visitor)

"""The screening test before writing, `/LANGUAGE/collect/NAME/screening/write`: a form that needs no scripts."""

from datetime import timedelta
from typing import Any

from aiohttp import web

from arramon_collecting.rules.screening import CHOICES, RIGHT_WRITE, Screening, wrong_answers
from arramon_collecting.storage.records import WRITE, Collection
from arramon_collecting.storage.workers import check_active
from arramon_collecting.web.access import Visitor
from arramon_collecting.web.handlers import BASE, Handlers, request_texts, see_other
from arramon_collecting.web.writing.guidelines import guidelines_context

ADDRESS = f"{BASE}/screening/{WRITE}"


class WriteScreening:
    """The screening test before writing (paper, appendix "Qualification Tests").

    Args:
        handlers: what all pages of collections share.
    """

    def __init__(self, handlers: Handlers) -> None:
        self._handlers = handlers

    def routes(self) -> list[web.RouteDef]:
        """Return the routes of the test."""
        guarded = self._handlers.guarded
        return [web.get(ADDRESS, guarded(self._ask)), web.post(ADDRESS, guarded(self._judge))]

    def close(self) -> None:
        """End nothing: the test holds nothing open."""

    async def _ask(self, request: web.Request) -> web.Response:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            found = _standing(visitor)
            if found.passed_at is not None:
                return see_other(_home(request))
            return self._page(request, collection, visitor, found, ())

        return await self._handlers.run(make)

    async def _judge(self, request: web.Request) -> web.Response:
        fields = await self._handlers.form(request)

        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            self._handlers.check(request, visitor, fields)
            check_active(visitor.worker)
            before, settings = _standing(visitor), collection.settings
            wrong = wrong_answers(fields, RIGHT_WRITE)
            found = before.answered(
                is_right=not wrong,
                now=self._handlers.store.clock(),
                attempts=settings.screening_attempts,
                pause=timedelta(minutes=settings.screening_pause_minutes),
            )
            if found != before:
                self._handlers.store.workers.record_screening(visitor.worker.worker_id, WRITE, found.as_stored())
            if found.passed_at is not None:
                return see_other(f"{_home(request)}?notice=passed_write")
            return self._page(request, collection, visitor, found, wrong)

        return await self._handlers.run(make)

    def _page(
        self,
        request: web.Request,
        collection: Collection,
        visitor: Visitor,
        found: Screening,
        wrong: tuple[str, ...],
    ) -> web.Response:
        attempts = collection.settings.screening_attempts
        context: dict[str, Any] = {
            "questions": [{"name": name, "choices": CHOICES, "right": right} for name, right in RIGHT_WRITE.items()],
            "wrong": wrong,
            "attempts": attempts,
            "attempts_left": attempts - found.attempts,
            "paused_until": found.until if found.is_paused(self._handlers.store.clock()) else None,
            **guidelines_context(request_texts(request), collection, is_open=True),
        }
        return self._handlers.page(request, "write/screening.html", collection, context, visitor=visitor)


def _standing(visitor: Visitor) -> Screening:
    return Screening.stored(visitor.worker.screening.get(WRITE, {}))


def _home(request: web.Request) -> str:
    return request.path.partition("/screening/")[0] + "/"

"""The pages of a worker: consent, what is next, counts and money, giving back, leaving, deletion of the data."""

from collections.abc import Callable, Mapping

from aiohttp import web

from arramon_collecting.storage.people.records import HOST
from arramon_collecting.storage.records import Collection
from arramon_collecting.web.access import Visitor, delete_cookie
from arramon_collecting.web.handlers import BASE, Handler, Handlers, home_address, request_texts, see_other
from arramon_collecting.web.people.task_claims import TaskClaims
from arramon_collecting.web.people.worker_view import consent_view, worker_view
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput

Act = Callable[[web.Request, Collection, Visitor, Mapping[str, str]], web.Response]
"""Answers a form; it runs in a thread."""

NOTICES = frozenset(("nothing_write", "nothing_verify", "returned", "saved", "sent", "passed"))
"""Notices that an address may ask a worker's page to show."""


class WorkerPages:
    """The pages of a worker.

    Args:
        handlers: what all pages of collections share.
        splits: the served splits, by name.
    """

    def __init__(self, handlers: Handlers, splits: Mapping[str, Split]) -> None:
        self._handlers = handlers
        self._claims = TaskClaims(handlers.store, splits)

    def routes(self) -> list[web.RouteDef]:
        """Return the routes."""
        guarded = self._handlers.guarded
        acts: dict[str, Act] = {
            "consent": self._consent,
            "take": self._take,
            "return": self._return,
            "resume": self._resume,
            "contact": self._contact,
            "leave": self._leave,
            "forget": self._forget,
        }
        return [
            web.get(f"{BASE}/", guarded(self._show)),
            web.get(BASE, guarded(self._redirect)),
            web.get(f"{BASE}/forget", guarded(self._ask_forget)),
            *(web.post(f"{BASE}/{name}", guarded(self._form(act))) for name, act in acts.items()),
        ]

    def close(self) -> None:
        """Do nothing: there is nothing to end."""

    async def _redirect(self, request: web.Request) -> web.StreamResponse:
        return see_other(home_address(request))

    async def _show(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            if visitor.worker.role == HOST:
                return see_other(f"{home_address(request)}review")
            if visitor.worker.consented_at is None:
                context = consent_view(collection, visitor.worker, request_texts(request).language)
                return self._handlers.page(request, "collect/consent.html", collection, context, visitor=visitor)
            view = worker_view(self._handlers.store, collection, visitor.worker)
            notice = request.query.get("notice", "")
            view["notice"] = notice if notice in NOTICES else ""
            return self._handlers.page(request, "collect/worker.html", collection, view, visitor=visitor)

        return await self._handlers.run(make)

    async def _ask_forget(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            return self._handlers.page(request, "collect/forget.html", collection, {}, visitor=visitor)

        return await self._handlers.run(make)

    def _form(self, act: Act) -> Handler:
        """Return the handler of a form, which checks that it comes from the worker's own page."""

        async def handle(request: web.Request) -> web.StreamResponse:
            fields = await self._handlers.form(request)

            def make() -> web.Response:
                collection, visitor = self._handlers.visitor(request)
                self._handlers.check(request, visitor, fields)
                return act(request, collection, visitor, fields)

            return await self._handlers.run(make)

        return handle

    def _consent(
        self, request: web.Request, collection: Collection, visitor: Visitor, fields: Mapping[str, str]
    ) -> web.Response:
        if fields.get("agree") != "yes" or fields.get("keep_texts") not in ("yes", "no"):
            raise BadInput("the form is incomplete: expected that you agree, and whether your texts stay")
        language, settings = request_texts(request).language, collection.settings
        if fields.get("consent_hash") != settings.consent_shown(language).hash_with(settings.licence):
            raise BadInput("the form is that of another text; reload the page")
        workers, worker_id = self._handlers.store.workers, visitor.worker.worker_id
        # The address first: if it is malformed, nothing is recorded.
        workers.set_contact(worker_id, email=fields.get("email", ""), page_language=language)
        workers.consent(visitor.worker, collection, keep_texts=fields["keep_texts"] == "yes", language=language)
        return see_other(home_address(request))

    def _take(
        self, request: web.Request, collection: Collection, visitor: Visitor, fields: Mapping[str, str]
    ) -> web.Response:
        """Give out a task, or redirect to what is missing before."""
        address = self._claims.address(
            request, collection, visitor.worker, fields.get("stage", ""), text_id=fields.get("text", "")
        )
        return see_other(address or f"{home_address(request)}?notice=nothing_{fields['stage']}")

    def _return(self, request: web.Request, _: Collection, visitor: Visitor, fields: Mapping[str, str]) -> web.Response:
        tasks = self._handlers.store.tasks
        tasks.give_back(tasks.of_worker(visitor.worker, fields.get("task", "")).task_id)
        return see_other(f"{home_address(request)}?notice=returned")

    def _resume(self, request: web.Request, _: Collection, visitor: Visitor, fields: Mapping[str, str]) -> web.Response:
        tasks = self._handlers.store.tasks
        task = tasks.resume(tasks.of_worker(visitor.worker, fields.get("task", "")))
        return see_other(f"{home_address(request)}{task.stage}/{task.task_id}")

    def _contact(
        self, request: web.Request, _: Collection, visitor: Visitor, fields: Mapping[str, str]
    ) -> web.Response:
        language, workers = request_texts(request).language, self._handlers.store.workers
        workers.set_contact(visitor.worker.worker_id, email=fields.get("email", ""), page_language=language)
        return see_other(f"{home_address(request)}?notice=saved")

    def _leave(
        self, request: web.Request, collection: Collection, visitor: Visitor, _: Mapping[str, str]
    ) -> web.Response:
        self._handlers.store.removal.leave(visitor.worker)
        response = self._handlers.page(request, "collect/left.html", collection, {"forgotten": False})
        delete_cookie(response, collection.name)
        return response

    def _forget(
        self, request: web.Request, collection: Collection, visitor: Visitor, fields: Mapping[str, str]
    ) -> web.Response:
        if fields.get("sure") != "yes":
            raise BadInput("the form is incomplete: expected that you are sure")
        removed = self._handlers.store.removal.forget(collection, visitor.worker.worker_id)
        context = {"forgotten": True, "removed": removed}
        response = self._handlers.page(request, "collect/left.html", collection, context)
        delete_cookie(response, collection.name)
        return response

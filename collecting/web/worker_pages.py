"""The pages of a worker: consent, what is next, counts and money, giving back, leaving, deletion of the data."""

import re
from collections.abc import Callable, Mapping
from dataclasses import replace

from aiohttp import web

from arramon_collecting.episodes import episodes_to_write, golds
from arramon_collecting.rules.next_step import Step, next_step
from arramon_collecting.storage.records import ACTIVE, HOST, LEFT, VERIFY, WRITE, Collection, Task, Worker
from arramon_collecting.storage.workers import check_active
from arramon_collecting.web.access import Visitor, delete_cookie
from arramon_collecting.web.handlers import BASE, Handler, Handlers, request_texts, see_other
from arramon_collecting.web.worker_view import worker_view
from arramon_server.episodes.splits import Split
from arramon_server.errors import BadInput, NotFound, quoted

Act = Callable[[web.Request, Collection, Visitor, Mapping[str, str]], web.Response]
"""Answers a form; it runs in a thread."""

NOTICES = frozenset(("nothing", "returned", "saved", "sent", "passed_write"))
"""Notices that an address may ask a worker's page to show."""


class WorkerPages:
    """The pages of a worker.

    Args:
        handlers: what all pages of collections share.
        splits: the served splits, by name.
    """

    def __init__(self, handlers: Handlers, splits: Mapping[str, Split]) -> None:
        self._handlers = handlers
        self._splits = splits

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
        return see_other(_home(request))

    async def _show(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            if visitor.worker.role == HOST:
                return see_other(f"{_home(request)}review")
            if visitor.worker.consented_at is None:
                context = {
                    "has_mail": bool(collection.settings.smtp.host),
                    "paragraphs": [text.strip() for text in re.split(r"\n\s*\n", collection.consent) if text.strip()],
                }
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
        if fields.get("consent_hash") != collection.consent_hash:
            raise BadInput("the form is that of another text; reload the page")
        workers, worker_id = self._handlers.store.workers, visitor.worker.worker_id
        # The address first: if it is malformed, nothing is recorded.
        workers.set_contact(worker_id, email=fields.get("email", ""), page_language=request_texts(request).language)
        workers.consent(visitor.worker, collection, keep_texts=fields["keep_texts"] == "yes")
        return see_other(_home(request))

    def _take(
        self, request: web.Request, collection: Collection, visitor: Visitor, fields: Mapping[str, str]
    ) -> web.Response:
        """Give out a task, or redirect to what is missing before."""
        worker, stage = visitor.worker, fields.get("stage", "")
        if stage not in (WRITE, VERIFY) or stage not in worker.stages:
            raise BadInput(f"the stage is {quoted(stage)}, expected {' or '.join(worker.stages)}")
        step = _next_step(worker, stage)
        if step is Step.CONSENT:
            return see_other(_home(request))
        if worker.state == LEFT:
            self._handlers.store.workers.set_state(worker.worker_id, ACTIVE)
            worker = replace(worker, state=ACTIVE)
        check_active(worker)
        if step is not Step.TASK:
            address = {Step.DEVICE: f"{step}?stage={stage}", Step.SCREENING: f"{step}/{stage}"}.get(step, str(step))
            return see_other(f"{_home(request)}{address}")
        task = self._claim(collection, worker, stage, fields.get("text", ""))
        return see_other(f"{_home(request)}{stage}/{task.task_id}" if task else f"{_home(request)}?notice=nothing")

    def _claim(self, collection: Collection, worker: Worker, stage: str, text_id: str) -> Task | None:
        tasks, split = self._handlers.store.tasks, self._splits.get(collection.split)
        if split is None:
            raise NotFound(f"the split {collection.split!r} of this collection is not served")
        if stage == VERIFY:
            return tasks.claim_verify(collection, worker, golds(split, collection))
        if text_id:
            return tasks.claim_mend(collection, worker, text_id)
        return tasks.claim_write(collection, worker, episodes_to_write(split, collection))

    def _return(self, request: web.Request, _: Collection, visitor: Visitor, fields: Mapping[str, str]) -> web.Response:
        tasks = self._handlers.store.tasks
        tasks.give_back(tasks.of_worker(visitor.worker, fields.get("task", "")).task_id)
        return see_other(f"{_home(request)}?notice=returned")

    def _resume(self, request: web.Request, _: Collection, visitor: Visitor, fields: Mapping[str, str]) -> web.Response:
        tasks = self._handlers.store.tasks
        task = tasks.resume(tasks.of_worker(visitor.worker, fields.get("task", "")))
        return see_other(f"{_home(request)}{task.stage}/{task.task_id}")

    def _contact(
        self, request: web.Request, _: Collection, visitor: Visitor, fields: Mapping[str, str]
    ) -> web.Response:
        language, workers = request_texts(request).language, self._handlers.store.workers
        workers.set_contact(visitor.worker.worker_id, email=fields.get("email", ""), page_language=language)
        return see_other(f"{_home(request)}?notice=saved")

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


def _next_step(worker: Worker, stage: str) -> Step:
    return next_step(
        stage,
        consented=worker.consented_at is not None,
        device=worker.device,
        screening=worker.screening,
        placement_passed=worker.placement_passed_at is not None,
    )


def _home(request: web.Request) -> str:
    return f"/{request_texts(request).language}/collect/{request.match_info['collection']}/"

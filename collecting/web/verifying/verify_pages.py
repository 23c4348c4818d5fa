"""The page on which a worker follows a text: game, flags, hand-in. It shows neither scores nor maps."""

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from aiohttp import web

from arramon_collecting.rules.flags import KINDS, PARTS, read_flags
from arramon_collecting.rules.next_step import Step
from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.work.records import EXPIRED, OPEN, RETURNED, SUBMITTED, VERIFY, Task
from arramon_collecting.storage.work.submissions import Play
from arramon_collecting.verifying.walk_results import WalkResult, WalkResults
from arramon_collecting.web.access import Visitor
from arramon_collecting.web.handlers import BASE, Handlers, home_address, json_response, request_texts, see_other
from arramon_collecting.web.people.task_claims import step_before
from arramon_collecting.web.verifying.verify_settings import play_settings
from arramon_collecting.web.verifying.verify_socket import VerifySockets
from arramon_server.errors import Conflict, NotFound
from arramon_server.runs.storage.causes import FORFEITED
from arramon_server.runs.storage.journal import Journal
from arramon_server.web.page_texts import PageTexts

TASK = f"{BASE}/verify/{{task:[0-9a-f]{{32}}}}"

FLAG_FIELD = "flag-"
"""Beginning of the names of the boxes in the form."""

ENDED_TASKS = 20
"""Number of a worker's latest tasks whose runs are ended if they were given back."""


class VerifyPages:
    """The page of a verification, its WebSocket, and what it sends.

    Args:
        handlers: what all pages of collections share.
        sockets: serves the WebSocket.
        journal: storage of the runs.
        results: reads the results of the runs.
    """

    def __init__(self, handlers: Handlers, sockets: VerifySockets, journal: Journal, results: WalkResults) -> None:
        self._handlers = handlers
        self._sockets = sockets
        self._journal = journal
        self._results = results

    def routes(self) -> list[web.RouteDef]:
        """Return the routes."""
        guarded = self._handlers.guarded
        return [
            web.get(TASK, guarded(self._show)),
            web.get(f"{TASK}/socket", guarded(self._serve)),
            web.post(f"{TASK}/flags", guarded(self._save_flags)),
            web.post(f"{TASK}/hand-in", guarded(self._hand_in)),
        ]

    def close(self) -> None:
        """End the WebSockets' services."""
        self._sockets.close()

    async def _show(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            task = self._task(request, visitor)
            if task.state == EXPIRED:
                with suppress(Conflict):
                    task = self._handlers.store.tasks.resume(task)
            step = step_before(visitor.worker, VERIFY)
            if step is not Step.TASK:
                return see_other(f"{home_address(request)}{_address_of(step)}")
            if task.state != OPEN:
                return self._ended_page(request, collection, visitor, task)
            return self._page(request, collection, visitor, task)

        return await self._handlers.run(make)

    def _page(
        self, request: web.Request, collection: Collection, visitor: Visitor, task: Task, *, notice: str = ""
    ) -> web.Response:
        t = request_texts(request)
        here = f"{home_address(request)}verify/{task.task_id}"
        settings = play_settings(
            t, visitor, socket=f"{here}/socket", player=task.task_id, sizes=self._sockets.sizes
        ) | {"isTest": False, "lessons": 0, "flagsAddress": f"{here}/flags", "spoken": collection.language}
        context: dict[str, Any] = {
            "settings": settings,
            "notice": t(f"collect_verify.{notice}") if notice else "",
            "kinds": KINDS,
            "parts": [{"name": part, "title": _part_title(t, part)} for part in PARTS],
            "flags": task.position.get("flags", []),
            "hand_in_address": f"{here}/hand-in",
            "task": task,
        }
        return self._handlers.page(request, "collect/verify.html", collection, context, visitor=visitor)

    def _ended_page(self, request: web.Request, collection: Collection, visitor: Visitor, task: Task) -> web.Response:
        if task.state in (RETURNED, EXPIRED):
            return see_other(home_address(request))
        verification = self._handlers.store.verifications.get(task.task_id)
        t = request_texts(request)
        notice = (
            "" if verification.counts else t("collect_verify.too_fast", seconds=t.whole(round(verification.seconds)))
        )
        context = {"notice": notice, "amount": collection.settings.money(collection.settings.pay_verify)}
        return self._handlers.page(request, "collect/verify_done.html", collection, context, visitor=visitor)

    async def _serve(self, request: web.Request) -> web.StreamResponse:
        def find() -> tuple[Collection, Worker, Task]:
            collection, visitor = self._handlers.visitor(request)
            task = self._task(request, visitor)
            if task.state != OPEN or step_before(visitor.worker, VERIFY) is not Step.TASK:
                raise Conflict("this task cannot be played now; reload the page")
            return collection, visitor.worker, task

        collection, worker, task = await self._handlers.run(find)
        await self._end_returned(worker)
        return await self._sockets.serve_text(request, collection, worker, task)

    async def _save_flags(self, request: web.Request) -> web.StreamResponse:
        content = await self._handlers.json(request)

        def make() -> web.Response:
            _, visitor = self._handlers.visitor(request)
            self._handlers.check(request, visitor)
            task, flags = self._task(request, visitor), read_flags(content.get("flags"))
            self._handlers.store.tasks.touch(task.task_id, {"flags": list(flags)})
            return json_response({"flags": list(flags)})

        return await self._handlers.run(make)

    async def _hand_in(self, request: web.Request) -> web.StreamResponse:
        fields = await self._handlers.form(request)

        def make() -> web.Response:
            collection, visitor = self._handlers.visitor(request)
            self._handlers.check(request, visitor, fields)
            task = self._task(request, visitor)
            here = see_other(f"{home_address(request)}verify/{task.task_id}")
            if task.state == SUBMITTED:
                return here
            if task.run_id is None:
                raise Conflict("the text has not been followed yet")
            flags = _flags_of(fields)
            result = self._results.of(self._journal.run(task.run_id))
            if result.is_void:
                raise Conflict("a fault of the server ended the episode; reload the page to play it again")
            if result.cause == FORFEITED and not flags:
                return self._page(request, collection, visitor, task, notice="gave_up")
            # A task is submitted once, so that its own id is that of the submission.
            self._handlers.store.submissions.submit_verification(
                collection, task, task.task_id, _play_of(task.run_id, result, flags)
            )
            return here

        return await self._handlers.run(make)

    def _task(self, request: web.Request, visitor: Visitor) -> Task:
        task = self._handlers.store.tasks.of_worker(visitor.worker, request.match_info["task"])
        if task.stage != VERIFY:
            raise NotFound("there is no such verification")
        return task

    async def _end_returned(self, worker: Worker) -> None:
        """End the runs of tasks that the worker gave back: nobody goes on with them."""
        tasks = await self._handlers.run(lambda: self._handlers.store.tasks.all_of(worker.worker_id))
        for task in tasks[-ENDED_TASKS:]:
            if task.stage == VERIFY and task.state == RETURNED and task.run_id is not None:
                with suppress(Conflict):  # It has ended already.
                    await self._sockets.cancel(task.run_id)


def _address_of(step: Step) -> str:
    return {Step.CONSENT: "", Step.SCREENING: f"{Step.SCREENING}/{VERIFY}"}.get(step, str(step))


def _flags_of(fields: Mapping[str, str]) -> tuple[str, ...]:
    return read_flags([name.removeprefix(FLAG_FIELD) for name in fields if name.startswith(FLAG_FIELD)])


def _play_of(run_id: str, result: WalkResult, flags: tuple[str, ...]) -> Play:
    return Play(run_id, result.ndtw, result.ptc, result.cells, result.paths, flags, result.seconds)


def _part_title(t: PageTexts, part: str) -> str:
    turn, _, phase = part.partition("-")
    return t("collect_verify.part", turn=turn, phase=t(f"collect_verify.part_{phase}"))

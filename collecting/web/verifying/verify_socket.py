"""WebSockets of verifying and of the placement test: the play page's, on runs that belong to a worker's task."""

import asyncio
import time
from collections.abc import Callable

from aiohttp import web

from arramon_collecting.storage.people.records import Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.work.records import OPEN, Task
from arramon_collecting.verifying.placement_test import PlacementTest
from arramon_collecting.verifying.text_runs import (
    VERIFIERS,
    NoPractice,
    NoRuns,
    NoScores,
    TextGround,
    TextRuns,
    text_run_service,
)
from arramon_collecting.web.access import find_visitor
from arramon_server.errors import Conflict, NotFound, Unavailable
from arramon_server.runs.accounts.callers import UNAUTHENTICATED, Caller
from arramon_server.web.play.browser_access import BrowserAccess, check_origin
from arramon_server.web.play.play_ground import Practice
from arramon_server.web.play.play_page import SOCKET_SHARE
from arramon_server.web.play.play_socket import PlaySocket
from arramon_server.web.play.requests import MAX_REQUEST_BYTES
from arramon_server.web.play.socket_ground import PracticeGround, SocketGround
from arramon_server.web.web_parts import WebContext

TOUCH_SECONDS = 20.0
"""Interval at which a task is recorded as used while it is played."""


class VerifySockets:
    """Serves the WebSockets. Use it on the engine's event loop.

    Args:
        context: the services of the server process.
        store: storage of the collections.

    Attributes:
        sizes: the largest and the smallest side length of the images, in pixels.
    """

    def __init__(self, context: WebContext, store: Store) -> None:
        self._context = context
        self._store = store
        self._runs = text_run_service(context)
        practice = Practice(context.config.camera, context.threads, context.renderer)
        self._test = PlacementTest(practice, store.workers.record_placement)
        self._open = 0
        self.sizes = (context.config.play_image_sizes[0], context.config.play_image_sizes[-1])

    def close(self) -> None:
        """End the placement test's engine."""
        self._test.close()

    async def cancel(self, run_id: str) -> None:
        """End the run of a task that is given back.

        Raises:
            Conflict: if it has ended already.
        """
        await self._runs.cancel(VERIFIERS, run_id)

    async def serve_text(
        self, request: web.Request, collection: Collection, worker: Worker, task: Task
    ) -> web.StreamResponse:
        """Serve the WebSocket of a verification's page until it is closed.

        Raises:
            Forbidden: if another site's page opens it.
            Unavailable: if too many people play.
            NotFound: if the request is for no WebSocket.
        """
        store, journal = self._store, self._context.journal

        def open_task() -> Task:
            found = store.tasks.of_worker(worker, task.task_id)
            if found.state != OPEN:
                raise Conflict(f"the task is {found.state}; it cannot be played any more")
            return found

        def set_run(before: str | None, run_id: str) -> str:
            return store.tasks.set_run(task.task_id, before, run_id)

        runs = TextRuns(self._context.database, journal, self._runs, open_task, set_run, collection.language)
        access = self._access(collection, VERIFIERS, lambda: store.tasks.touch(task.task_id))
        return await self._serve(request, access, TextGround(runs, NoScores(), self._context.engine), NoPractice())

    async def serve_placement(self, request: web.Request, collection: Collection, worker: Worker) -> web.StreamResponse:
        """Serve the WebSocket of the placement test's page until it is closed.

        Raises:
            Forbidden, Unavailable, NotFound: as for `serve_text`.
        """
        access = self._access(collection, UNAUTHENTICATED, lambda: None)
        ground = TextGround(NoRuns(), NoScores(), self._context.engine)
        return await self._serve(request, access, ground, self._test.of_worker(worker.worker_id))

    def _access(self, collection: Collection, caller: Caller, touch: Callable[[], object]) -> BrowserAccess:
        """Return the admission of a browser that is signed in; it is repeated while the WebSocket is open."""
        next_touch = time.monotonic()

        def admit(request: web.BaseRequest) -> None:
            nonlocal next_touch
            find_visitor(request, self._store, collection)
            if time.monotonic() >= next_touch:
                next_touch = time.monotonic() + TOUCH_SECONDS
                touch()

        async def authenticate(request: web.BaseRequest, token: str) -> Caller:  # noqa: ARG001, by cookie
            await asyncio.to_thread(admit, request)
            return caller

        return BrowserAccess(authenticate, self._context.access.count_stream, needs_token=False)

    async def _serve(
        self, request: web.Request, access: BrowserAccess, ground: SocketGround, practice: PracticeGround
    ) -> web.StreamResponse:
        check_origin(request)
        config = self._context.config
        if self._open >= max(1, config.max_calls // SOCKET_SHARE):
            raise Unavailable("too many people play at this server process; try again in a moment")
        socket = web.WebSocketResponse(
            heartbeat=config.keepalive_seconds, max_msg_size=2 * MAX_REQUEST_BYTES, compress=False
        )
        if not socket.can_prepare(request).ok:
            raise NotFound("this address is for the WebSocket of a page")
        self._open += 1
        try:
            await socket.prepare(request)
            await PlaySocket(socket, request, access, ground, practice, self._context.threads, self.sizes).serve()
        finally:
            self._open -= 1
        return socket

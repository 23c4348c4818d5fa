"""Joining a collection: by personal link, from a crowd platform, or as a host with a token."""

import hmac
from collections.abc import Iterator
from contextlib import contextmanager

from aiohttp import web

from arramon_collecting.storage.people.records import FORGOTTEN, Worker
from arramon_collecting.storage.records import Collection
from arramon_collecting.web.access import sign_in
from arramon_collecting.web.handlers import BASE, Handlers, home_address, see_other
from arramon_collecting.web.rate_limits import TRIES_A_MINUTE
from arramon_server.errors import BadInput, Forbidden, NotFound, Unauthenticated, quoted
from arramon_server.runs.accounts.callers import Role
from arramon_server.web.play.browser_access import BrowserAccess, check_origin

JOIN, HOST_SIGN_IN = f"{BASE}/join", f"{BASE}/host"

MAX_PLATFORM_ID = 200
"""Maximum number of characters of a platform's ids."""


class JoinPages:
    """Joining.

    Args:
        handlers: what all pages of collections share.
        access: authenticates hosts by token.
    """

    def __init__(self, handlers: Handlers, access: BrowserAccess) -> None:
        self._handlers = handlers
        self._access = access

    def routes(self) -> list[web.RouteDef]:
        """Return the routes."""
        guarded = self._handlers.guarded
        return [
            web.get(JOIN, guarded(self._join), allow_head=False),
            web.get(HOST_SIGN_IN, guarded(self._ask_token)),
            web.post(HOST_SIGN_IN, guarded(self._take_token)),
        ]

    def close(self) -> None:
        """Do nothing: there is nothing to end."""

    async def _join(self, request: web.Request) -> web.StreamResponse:
        """Sign in by the address, and redirect at once to one without the secret."""

        def make() -> web.Response:
            collection = self._handlers.collection(request)
            query = request.query
            key = query.get("key", "")
            if "worker" in query:
                ids = [query.get(name, "") for name in ("worker", "study", "session")]
                worker = self._from_platform(collection, key, *ids)
            else:
                worker = self._by_link(collection, key)
            response = see_other(home_address(request))
            sign_in(request, response, self._handlers.store, worker)
            return response

        with self._counting_failures(request):
            return await self._handlers.run(make)

    @contextmanager
    def _counting_failures(self, request: web.Request) -> Iterator[None]:
        """Limit the failed attempts of an address. Others are not limited: behind a proxy all have the same one."""
        try:
            yield
        except (BadInput, Forbidden, NotFound, Unauthenticated):
            self._handlers.limit(f"join {request.remote}", TRIES_A_MINUTE)
            raise

    def _by_link(self, collection: Collection, key: str) -> Worker:
        worker = self._handlers.store.workers.by_link(collection.name, key) if key else None
        if worker is None or worker.state == FORGOTTEN:
            raise Forbidden("this link is not valid; ask the host of this collection for a new one")
        return worker

    def _from_platform(self, collection: Collection, key: str, external: str, study: str, session: str) -> Worker:
        platform = collection.settings.platform
        if not platform.key or not hmac.compare_digest(key.encode(), platform.key.encode()):
            raise Forbidden("this address is not that of a study of this collection")
        if study not in platform.studies:
            raise NotFound(f"there is no study {quoted(study)} of this collection")
        if len(session) > MAX_PLATFORM_ID:
            raise BadInput(f"the session's id has {len(session)} characters; at most {MAX_PLATFORM_ID} are allowed")
        store = self._handlers.store
        worker = store.workers.join(collection, external, platform.studies[study].stages)
        store.visits.begin(worker.worker_id, study, session)
        return worker

    async def _ask_token(self, request: web.Request) -> web.StreamResponse:
        def make() -> web.Response:
            return self._handlers.page(request, "collect/host.html", self._handlers.collection(request), {})

        return await self._handlers.run(make)

    async def _take_token(self, request: web.Request) -> web.StreamResponse:
        check_origin(request)
        fields = await self._handlers.form(request)
        with self._counting_failures(request):
            caller = await self._access.authenticate(request, fields.get("token", "").strip())
            if caller.role is not Role.HOST or caller.account is None:
                raise Forbidden("the token is not one of a host")
            account = caller.account

        def make() -> web.Response:
            collection = self._handlers.collection(request)
            worker = self._handlers.store.workers.add_host(collection, account)
            response = see_other(f"{home_address(request)}review")
            sign_in(request, response, self._handlers.store, worker)
            return response

        return await self._handlers.run(make)

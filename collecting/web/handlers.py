"""What the handlers of all pages of collections share: threads, sign-in, error pages, and the rendering of pages."""

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar
from urllib.parse import parse_qsl

from aiohttp import web

from arramon.strict_json import NotJsonError, read_json
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.work.drafts import OlderDraft
from arramon_collecting.web.access import Visitor, check_csrf, find_host, find_visitor, renew_cookie
from arramon_collecting.web.rate_limits import CHANGES_A_MINUTE, RateLimits
from arramon_collecting.web.texts import languages_of, texts_of
from arramon_server.errors import (
    ArraMonError,
    BadInput,
    Conflict,
    Forbidden,
    NotFound,
    OverQuota,
    Unauthenticated,
    Unavailable,
)
from arramon_server.web.http_responses import HEADERS, respond
from arramon_server.web.page_texts import DEFAULT_LANGUAGE, PageTexts
from arramon_server.web.rendering import Renderer

BASE = "/{language:[a-z]{2,3}}/collect/{collection:[a-z0-9][a-z0-9_-]{0,49}}"
"""Beginning of all addresses of a collection's pages."""

MAX_BODY_BYTES = 320 << 10
"""Maximum size of a request's body."""

MAX_WAITING = 64
"""Maximum number of requests that wait for the threads."""

STATUSES: tuple[tuple[type[ArraMonError], int], ...] = (
    (Unauthenticated, 401),
    (Forbidden, 403),
    (NotFound, 404),
    (Conflict, 409),
    (OverQuota, 429),
    (BadInput, 400),
    (Unavailable, 503),
)
"""HTTP status of each kind of error."""

T = TypeVar("T")
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Handlers:
    """Base of the handlers.

    Args:
        store: storage of the collections.
        renderer: renders the templates, with the folder `collect` added.
    """

    def __init__(self, store: Store, renderer: Renderer) -> None:
        self.store = store
        self._renderer = renderer
        self._limits = RateLimits()
        self._threads = ThreadPoolExecutor(2, "collecting")
        self._waiting = 0

    def close(self) -> None:
        """End the threads, once they have done what they are doing."""
        self._threads.shutdown(wait=True, cancel_futures=True)

    async def run(self, work: Callable[[], T]) -> T:
        """Run work that uses the database or renders a page in a thread.

        Raises:
            Unavailable: if too much work is waiting.
        """
        if self._waiting >= MAX_WAITING:
            raise Unavailable("the server is busy; try again in a moment")
        self._waiting += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(self._threads, work)
        finally:
            self._waiting -= 1

    def guarded(self, handler: Handler) -> Handler:
        """Return a handler that answers errors: with a page, or with JSON if the request's body or answer is JSON."""

        async def handle(request: web.Request) -> web.StreamResponse:
            try:
                return await handler(request)
            except ArraMonError as error:
                return await asyncio.to_thread(self._error, request, error)

        return handle

    def collection(self, request: web.Request) -> Collection:
        """Return the collection of an address; to be called in a thread.

        Raises:
            NotFound: if there is none of that name.
        """
        return self.store.collections.get(request.match_info["collection"])

    def visitor(self, request: web.Request, *, host: bool = False) -> tuple[Collection, Visitor]:
        """Return the collection of an address, and who asks; to be called in a thread.

        Args:
            request: the request.
            host: whether only hosts may ask.

        Raises:
            NotFound, Unauthenticated: if the request is not allowed.
        """
        collection = self.collection(request)
        find = find_host if host else find_visitor
        return collection, find(request, self.store, collection)

    async def form(self, request: web.Request) -> dict[str, str]:
        """Return the fields of a form.

        Raises:
            BadInput: if it is too large or malformed.
        """
        body = await self.body(request)
        try:
            fields = web_form(body)
        except ValueError as error:
            raise BadInput(f"the form is malformed: {error}") from error
        return fields

    async def json(self, request: web.Request) -> dict[str, Any]:
        """Return the JSON object that a script sent.

        Raises:
            BadInput: if it is too large, or no JSON object.
        """
        try:
            content = read_json(await self.body(request), deepest=16)
        except NotJsonError as error:
            raise BadInput(f"the request {error}; expected a JSON object") from error
        if not isinstance(content, dict):
            raise BadInput("the request is no JSON object")
        return content

    async def body(self, request: web.Request) -> bytes:
        """Return a request's body.

        Raises:
            BadInput: if it is larger than MAX_BODY_BYTES.
        """
        length, parts = 0, []
        async for part in request.content.iter_chunked(1 << 16):
            length += len(part)
            if length > MAX_BODY_BYTES:
                raise BadInput(f"the request has more than {MAX_BODY_BYTES} bytes; send less")
            parts.append(part)
        return b"".join(parts)

    def check(self, request: web.Request, visitor: Visitor, fields: Mapping[str, object] | None = None) -> None:
        """Check that a request that changes state comes from a page of this server, and count it; see `check_csrf`.

        Raises:
            Forbidden: if it does not.
            OverQuota: if the worker sends too many.
        """
        check_csrf(request, visitor, fields)
        self.limit(f"worker {visitor.worker.worker_id}", CHANGES_A_MINUTE)

    def limit(self, key: str, most: int) -> None:
        """Count a request of a worker or an address.

        Raises:
            OverQuota: if there were `most` in the last minute already.
        """
        self._limits.count(key, most)

    def page(
        self,
        request: web.Request,
        template: str,
        collection: Collection | None,
        context: Mapping[str, Any],
        *,
        visitor: Visitor | None = None,
        status: int = 200,
    ) -> web.Response:
        """Render a page that no cache keeps; the cookie of an old sign-in is renewed.

        Args:
            request: the request.
            template: name of the template, such as `collect/worker.html`. It extends `collect/base.html`.
            collection: the collection, which the template sees; None on error pages without one.
            context: further variables of the template.
            visitor: who asks; the template sees `csrf` and `worker`.
            status: HTTP status.
        """
        t = request_texts(request)
        address = f"/{t.language}/collect/{collection.name}" if collection is not None else ""
        common = {
            "languages": languages_of(collection.settings.page_languages if collection is not None else ()),
            "collection": collection,
            "address": address,
            "worker": visitor.worker if visitor is not None else None,
            "csrf": visitor.csrf if visitor is not None else "",
        }
        here = request.rel_url.raw_path.removeprefix(f"/{t.language}")
        body = self._renderer.page(template, t, here, common | dict(context))
        response = respond(request, body, "text/html", status=status, cache="no-store")
        if visitor is not None:
            renew_cookie(request, response, self.store, visitor)
        return response

    def _error(self, request: web.Request, error: ArraMonError) -> web.Response:
        status = next((status for kind, status in STATUSES if isinstance(error, kind)), 500)
        if _wants_json(request):
            content: dict[str, Any] = {"error": str(error)}
            if isinstance(error, OlderDraft):
                content["newer"] = {"revision": error.newer.revision, "body": error.newer.body}
            response = json_response(content, status)
        else:
            key = f"collect_error.{status}"
            response = self.page(request, "collect/error.html", None, {"key": key, "error": str(error)}, status=status)
        if status in (429, 503):
            response.headers["Retry-After"] = "5"
        return response


def request_texts(request: web.Request) -> PageTexts:
    """Return the texts in the language of an address; English if it is none."""
    try:
        return texts_of(request.match_info.get("language", DEFAULT_LANGUAGE))
    except NotFound:
        return texts_of(DEFAULT_LANGUAGE)


def home_address(request: web.Request) -> str:
    """Return the address of a worker's own page in the page's language; the other pages are below it."""
    return f"/{request_texts(request).language}/collect/{request.match_info['collection']}/"


def json_response(content: Mapping[str, Any], status: int = 200) -> web.Response:
    """Return JSON that no cache keeps."""
    headers = {**HEADERS, "Cache-Control": "no-store"}
    body = json.dumps(content, ensure_ascii=False).encode()
    return web.Response(status=status, body=body, headers=headers, content_type="application/json")


def see_other(address: str) -> web.Response:
    """Return a redirect (303) that no cache keeps."""
    return web.Response(status=303, headers={**HEADERS, "Location": address, "Cache-Control": "no-store"})


def web_form(body: bytes) -> dict[str, str]:
    """Return the fields of a URL-encoded form.

    Raises:
        ValueError: if it is malformed.
    """
    pairs = parse_qsl(body.decode("ascii"), keep_blank_values=True, strict_parsing=bool(body), max_num_fields=100)
    return dict(pairs)


def _wants_json(request: web.Request) -> bool:
    return request.content_type == "application/json" or "application/json" in request.headers.get("Accept", "")

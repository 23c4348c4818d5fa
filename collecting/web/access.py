"""Sign-in of workers and hosts by cookie, renewal of cookies, and protection against forged requests."""

import hmac
from collections.abc import Mapping
from dataclasses import dataclass

from aiohttp import web

from arramon_collecting.storage.people.records import HOST, Worker
from arramon_collecting.storage.people.sign_ins import LIFETIME
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_server.errors import Forbidden, NotFound, Unauthenticated
from arramon_server.web.play.browser_access import PROXY_HEADERS, check_origin

CSRF_FIELD, CSRF_HEADER = "csrf", "X-CSRF-Token"
"""Form field and header in which a request that changes state repeats the value of the sign-in."""


@dataclass(frozen=True, slots=True)
class Visitor:
    """The worker or host of a request.

    Attributes:
        worker: who signed in.
        csrf: value that forms and scripts of the page repeat.
        cookie: the browser's cookie.
    """

    worker: Worker
    csrf: str
    cookie: str


def cookie_name(collection: str) -> str:
    """Return the name of a collection's cookie: one person may take part in several collections."""
    return f"arramon_collect_{collection}"


def sign_in(request: web.BaseRequest, response: web.StreamResponse, store: Store, worker: Worker) -> None:
    """Sign a worker in, by a cookie in the response."""
    _set_cookie(request, response, worker.collection, store.sign_ins.open(worker.worker_id))


def find_visitor(request: web.BaseRequest, store: Store, collection: Collection) -> Visitor:
    """Return who a request comes from.

    Raises:
        Unauthenticated: if it has no cookie, or one that is forged or has expired.
    """
    cookie = request.cookies.get(cookie_name(collection.name), "")
    found = store.sign_ins.find(collection.name, cookie) if cookie else None
    if found is None:
        raise Unauthenticated("not signed in: open your personal link again")
    return Visitor(store.workers.get(found.worker_id), found.csrf, cookie)


def find_host(request: web.BaseRequest, store: Store, collection: Collection) -> Visitor:
    """Return the host that a request comes from.

    Raises:
        Unauthenticated: as for `find_visitor`.
        NotFound: if a worker signed in: for workers there are no such pages.
    """
    visitor = find_visitor(request, store, collection)
    if visitor.worker.role != HOST:
        raise NotFound("there is no such page")
    return visitor


def check_csrf(request: web.BaseRequest, visitor: Visitor, fields: Mapping[str, object] | None = None) -> None:
    """Check that a request that changes state was sent by a page of this server.

    Args:
        request: the request.
        visitor: who it comes from.
        fields: fields of a form; None if it is sent by a script, with the header.

    Raises:
        Forbidden: if it was not.
    """
    given = request.headers.get(CSRF_HEADER) or (fields or {}).get(CSRF_FIELD) or ""
    if not isinstance(given, str) or not hmac.compare_digest(given.encode(), visitor.csrf.encode()):
        raise Forbidden("the request does not come from a page of this collection; reload the page and try again")
    if "Origin" in request.headers and request.headers["Origin"] != "null":
        check_origin(request)


def renew_cookie(request: web.BaseRequest, response: web.StreamResponse, store: Store, visitor: Visitor) -> None:
    """Replace the browser's cookie in the response if it is old."""
    if (renewed := store.sign_ins.renew(visitor.cookie)) is not None:
        _set_cookie(request, response, visitor.worker.collection, renewed)


def delete_cookie(response: web.StreamResponse, collection: str) -> None:
    """Delete the browser's cookie."""
    response.del_cookie(cookie_name(collection), path="/")


def _set_cookie(request: web.BaseRequest, response: web.StreamResponse, collection: str, cookie: str) -> None:
    response.set_cookie(
        cookie_name(collection),
        cookie,
        max_age=int(LIFETIME.total_seconds()),
        path="/",
        secure=not _is_plain_loopback(request),
        httponly=True,
        samesite="Lax",
    )
    response.headers["Cache-Control"] = "no-store"


def _is_plain_loopback(request: web.BaseRequest) -> bool:
    """Return whether the browser is on this machine and uses HTTP, for which it would not store a secure cookie."""
    host = request.headers.get("Host", "").rpartition(":")[0].strip("[]") or request.headers.get("Host", "")
    is_loopback = host in ("localhost", "127.0.0.1", "::1")
    return is_loopback and not request.secure and not any(name in request.headers for name in PROXY_HEADERS)

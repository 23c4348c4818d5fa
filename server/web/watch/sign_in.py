"""Sign-in to the watch pages: a token, sent once in a form, is exchanged for a watch pass, which a cookie keeps."""

import asyncio
import time
from collections.abc import Awaitable, Callable
from urllib.parse import urlsplit

from aiohttp import web

from arramon_server.errors import Forbidden, Unauthenticated
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.accounts.watch_passes import WatchPasses
from arramon_server.web.watch.viewer_addresses import is_loopback_host

COOKIE = "arramon-watch"
"""Name of the cookie. Scripts cannot read it, other sites cannot send it, and it ends with the browser."""

MAX_FORM_BYTES = 2048
"""Largest form that is read."""

CHECKED_SECONDS = 2.0
"""Time for which a pass that was checked is not looked up again, as with tokens."""

CACHED_PASSES = 1000

Authenticate = Callable[[web.BaseRequest, str], Awaitable[Caller]]


class SignIn:
    """Exchanges tokens for passes, and finds the callers of passes.

    Args:
        authenticate: returns the caller of a request with a token, under the rules of gRPC calls: tokens are accepted
            over TLS, or from this machine. It raises Unauthenticated or Forbidden.
        passes: issues and checks passes.
    """

    def __init__(self, authenticate: Authenticate, passes: WatchPasses) -> None:
        self._authenticate = authenticate
        self._passes = passes
        self._checked: dict[str, tuple[Caller | None, float]] = {}

    async def issue(self, request: web.Request) -> str:
        """Return a pass for the token in a request's form, in its field "token".

        Raises:
            Unauthenticated: if the form has no token that is accepted.
            Forbidden: if the form is from another site, or tokens are not accepted over the connection.
        """
        check_same_origin(request)
        is_form = request.content_type == "application/x-www-form-urlencoded"
        if not is_form or request.content_length is None or request.content_length > MAX_FORM_BYTES:
            raise Unauthenticated(f"expected a form of at most {MAX_FORM_BYTES} bytes with a token")
        token = (await request.post()).get("token", "")
        if not isinstance(token, str) or not token.strip():
            raise Unauthenticated("authentication required: no token was sent")
        await self._authenticate(request, token.strip())
        return await asyncio.to_thread(self._passes.issue, token.strip())

    def caller(self, request: web.BaseRequest) -> Caller | None:
        """Return the caller of a request's pass; None if it has none that is accepted. Call it in a thread."""
        sent = request.cookies.get(COOKIE, "")
        if not sent:
            return None
        caller, until = self._checked.get(sent, (None, 0.0))
        if until < time.monotonic():
            try:
                caller = self._passes.caller(sent)
            except Unauthenticated:
                caller = None
            if len(self._checked) >= CACHED_PASSES:
                self._checked.clear()
            self._checked[sent] = caller, time.monotonic() + CHECKED_SECONDS
        return caller


def keep_pass(request: web.BaseRequest, response: web.Response, watch_pass: str) -> None:
    """Let the browser keep a pass until it ends; an empty one removes what it has.

    Tokens are accepted over TLS or from this machine only, so only on this machine the connection may be unencrypted.
    """
    is_local = is_loopback_host(urlsplit(f"//{request.host}").hostname or "")
    options = {"path": "/", "secure": not is_local, "httponly": True, "samesite": "Strict"}
    if watch_pass:
        response.set_cookie(COOKIE, watch_pass, **options)  # type: ignore[arg-type]
    else:
        response.del_cookie(COOKIE, **options)  # type: ignore[arg-type]


def check_same_origin(request: web.BaseRequest) -> None:
    """Check that a form was sent by a page of this server. As pages send no referrer, browsers hide its origin.

    Raises:
        Forbidden: if it was not.
    """
    site = request.headers.get("Sec-Fetch-Site", "none")
    if site != "same-origin":
        raise Forbidden(f"this form was sent by a page of {site} origin, expected one of this server")

"""What the play page needs of a server process to admit a browser, and the check of where its request comes from."""

from collections.abc import Awaitable, Callable
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from ipaddress import ip_address
from urllib.parse import urlsplit

from aiohttp import web

from arramon_server.errors import Forbidden
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.storage.records import Run

PROXY_HEADERS = ("Forwarded", "Via", "X-Forwarded-For", "X-Forwarded-Proto")


@dataclass(frozen=True, slots=True)
class BrowserAccess:
    """Authentication and limits, which are those of gRPC calls.

    Attributes:
        authenticate: returns the caller of a request with a token, which is empty for none; it raises
            Unauthenticated or Forbidden if the caller may not play.
        count_stream: counts a stream as open while the context is entered; it raises OverQuota.
        needs_token: whether nobody plays without a token.
    """

    authenticate: Callable[[web.BaseRequest, str], Awaitable[Caller]]
    count_stream: Callable[[Caller, Run, str], AbstractAsyncContextManager[None]]
    needs_token: bool


def check_origin(request: web.BaseRequest) -> None:
    """Check that a WebSocket was opened by a page of this server, not by another site in the person's browser.

    Raises:
        Forbidden: if it was not.
    """
    origin, host = request.headers.get("Origin", ""), request.headers.get("Host", "")
    found, expected = urlsplit(origin), urlsplit(f"//{host}")
    try:
        same_port = expected.port is None or found.port == expected.port  # Proxies may leave out the port.
    except ValueError:
        same_port = False
    if not origin or found.hostname != expected.hostname or not same_port:
        raise Forbidden(f"the page that opened this connection is of {origin or 'no site'}, expected one of {host}")
    # A site that points its own name at this machine has the same origin and host.
    is_proxied = any(name in request.headers for name in PROXY_HEADERS)
    if _is_this_machine(request.remote) and not is_proxied and not _is_this_machine(expected.hostname):
        raise Forbidden(f"the page is of {host}, expected localhost, as this connection comes from the same machine")


def _is_this_machine(host: str | None) -> bool:
    """Return whether a host is written as a loopback address or `localhost`. No name is resolved."""
    try:
        return host == "localhost" or ip_address((host or "").partition("%")[0]).is_loopback
    except ValueError:
        return False

"""Admission of browsers to play: the authentication and the stream limits of gRPC calls, for HTTP requests."""

from ipaddress import ip_address

from aiohttp import web

from arramon_server.api.authentication import Authentication, anonymous_caller, is_on_same_machine
from arramon_server.api.interceptor import CallOrigin
from arramon_server.api.stream_limits import StreamLimits
from arramon_server.configuration.config import Config
from arramon_server.runs.accounts.callers import ANONYMOUS, UNAUTHENTICATED, Caller
from arramon_server.web.play.browser_access import BrowserAccess


def browser_access(authentication: Authentication, limits: StreamLimits, config: Config) -> BrowserAccess:
    """Return the admission of browsers.

    Args:
        authentication: authenticates callers.
        limits: limits of open streams.
        config: the server's settings.
    """

    async def authenticate(request: web.BaseRequest, token: str) -> Caller:
        origin = _origin_of(request, token)
        caller = await authentication.playing_caller(origin)
        # The pages may be reached from other machines although gRPC is not.
        return UNAUTHENTICATED if caller == ANONYMOUS and not is_on_same_machine(origin) else caller

    return BrowserAccess(authenticate, limits.count, needs_token=anonymous_caller(config) is None)


def _origin_of(request: web.BaseRequest, token: str) -> CallOrigin:
    """Return the origin of a request, as gRPC would describe it."""
    headers = [(name.lower(), value) for name, value in request.headers.items() if name.lower() != "authorization"]
    if token:
        headers.append(("authorization", f"Bearer {token}"))
    return CallOrigin(_peer(request.remote), request.secure, tuple(headers))


def _peer(remote: str | None) -> str:
    if not remote:
        return ""
    is_old = ip_address(remote.partition("%")[0]).version == 4
    return f"ipv4:{remote}:0" if is_old else f"ipv6:[{remote}]:0"

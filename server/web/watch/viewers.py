"""Callers of the pages, which have no sign-in: everybody, or those who may play without a token, as over gRPC."""

from ipaddress import ip_address
from urllib.parse import urlsplit

from aiohttp import web

from arramon_server.configuration.config import Config
from arramon_server.runs.accounts.callers import ANONYMOUS, READER, UNAUTHENTICATED, Caller

PROXY_HEADERS = ("Forwarded", "Via", "X-Forwarded-For")
"""Headers that proxies add: what they forward may come from another machine."""


class Viewers:
    """Derives the caller of a request for a page.

    Args:
        anonymous: the setting of that name: whether anyone may play without a token; None for this machine only.
        own_machine: whether only this machine can reach the server over gRPC.
    """

    def __init__(self, anonymous: bool | None = False, *, own_machine: bool = False) -> None:
        self._anonymous = anonymous
        self._own_machine = own_machine

    @classmethod
    def of(cls, config: Config) -> "Viewers":
        """Return the viewers under a host's settings."""
        return cls(config.anonymous, own_machine=config.is_for_own_machine)

    def caller(self, request: web.BaseRequest) -> Caller:
        """Return the caller of a request: as over gRPC for one without a token, or READER if that may not play."""
        if self._own_machine and self._anonymous is not False and _is_local(request):
            return ANONYMOUS
        return UNAUTHENTICATED if self._anonymous else READER


NOBODY = Viewers()
"""Viewers on a server where nobody plays without a token: they see what is published."""


def _is_local(request: web.BaseRequest) -> bool:
    """Return whether a request comes from this machine, through no proxy, and names this machine.

    A site elsewhere can let its own name lead to this machine, in the browser of somebody who sits at it.
    """
    peer = request.transport.get_extra_info("peername") if request.transport is not None else None
    if not peer or any(name in request.headers for name in PROXY_HEADERS):
        return False
    return _is_loopback(str(peer[0])) and _is_loopback(urlsplit(f"//{request.host}").hostname or "")


def _is_loopback(host: str) -> bool:
    """Return whether a host is written as `localhost` or a loopback address. No name is resolved."""
    try:
        return host == "localhost" or ip_address(host.partition("%")[0]).is_loopback
    except ValueError:
        return False

"""Whether a request for a page comes from the machine of the server itself."""

from ipaddress import ip_address
from urllib.parse import urlsplit

from aiohttp import web

PROXY_HEADERS = ("Forwarded", "Via", "X-Forwarded-For")
"""Headers that proxies add: what they forward may come from another machine."""


def is_local(request: web.BaseRequest) -> bool:
    """Return whether a request comes from this machine, through no proxy, and names this machine.

    A site elsewhere can let its own name lead to this machine, in the browser of somebody who sits at it.
    """
    peer = request.transport.get_extra_info("peername") if request.transport is not None else None
    if not peer or any(name in request.headers for name in PROXY_HEADERS):
        return False
    return is_loopback_host(str(peer[0])) and is_loopback_host(urlsplit(f"//{request.host}").hostname or "")


def is_loopback_host(host: str) -> bool:
    """Return whether a host is written as `localhost` or a loopback address. No name is resolved."""
    try:
        return host == "localhost" or ip_address(host.partition("%")[0]).is_loopback
    except ValueError:
        return False

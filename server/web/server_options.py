"""Options with which the client reaches this server, as in the commands on an empty leaderboard."""

from ipaddress import ip_address

from aiohttp import web

from arramon_server.addresses import is_loopback
from arramon_server.configuration.config import Config
from arramon_server.web.watch.viewer_addresses import is_local
from arramon_server.web.watch.viewers import NOBODY, Viewers

UNKNOWN_HOST, UNKNOWN_ADDRESS = "host.example", "host.example:50551"
"""Shown in place of what is not known: a proxy in front, for example, has an address of its own."""


class ServerOptions:
    """The options for the callers of pages.

    Args:
        address: address at which clients reach the server.
        is_encrypted: whether connections to it are encrypted.
        viewers: says who may play without a token.
    """

    def __init__(
        self, address: str = UNKNOWN_ADDRESS, *, is_encrypted: bool = False, viewers: Viewers = NOBODY
    ) -> None:
        self._address = address
        self._is_local = is_loopback(address)
        self._is_encrypted = is_encrypted
        self._viewers = viewers

    @classmethod
    def of(cls, config: Config, address: str, viewers: Viewers) -> "ServerOptions":
        """Return the options under a host's settings.

        Args:
            config: the settings.
            address: address on which the server listens, with its actual port.
            viewers: says who may play without a token.
        """
        is_encrypted = config.tls_certificate is not None or config.trust_proxy
        reached = UNKNOWN_ADDRESS if config.trust_proxy else reached_address(address)
        return cls(reached, is_encrypted=is_encrypted, viewers=viewers)

    def text(self, request: web.BaseRequest) -> str:
        """Return the options for the caller of a request."""
        address = UNKNOWN_ADDRESS if self._is_local and not is_local(request) else self._address
        token = " --token-file token" if self._viewers.needs_token(request) else ""
        return f"--server {address}{' --tls' if self._is_encrypted else ''}{token}"


def reached_address(listen: str) -> str:
    """Return the address at which a server is reached that listens on an address, as far as this is known."""
    if listen.startswith("unix:"):
        return UNKNOWN_ADDRESS
    host, _, port = listen.rpartition(":")
    try:
        listens_everywhere = ip_address(host.strip("[]")).is_unspecified
    except ValueError:  # a name
        return listen
    return f"{UNKNOWN_HOST}:{port}" if listens_everywhere else listen

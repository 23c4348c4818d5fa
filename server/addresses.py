"""Addresses to listen on: their syntax, whether they are local, and whether they are free."""

import ipaddress
import socket
from pathlib import Path

from arramon_server.errors import BadInput

FORM = "host:port or unix:/path"
TCP_FORM = "host:port"


def is_address(text: str) -> bool:
    """Return whether a text is `host:port` or `unix:/path`."""
    return (text.startswith("unix:") and text != "unix:") or is_tcp_address(text)


def is_tcp_address(text: str) -> bool:
    """Return whether a text is `host:port`."""
    host, _, port = text.rpartition(":")
    return bool(host) and port.isascii() and port.isdecimal() and int(port) <= 65535


def is_loopback(address: str) -> bool:
    """Return whether only this machine can reach an address: a Unix socket or a loopback address."""
    return address.startswith("unix:") or (all(ip.is_loopback for ip in _found(address)) and bool(_found(address)))


def check_address_free(listen: str) -> None:
    """Check that this process can listen on an address: it belongs to this machine, and no process uses its port.

    Raises:
        BadInput: if it cannot listen there; the message says why.
    """
    try:
        if listen.startswith("unix:"):
            Path(listen.removeprefix("unix:")).parent.stat()
            return
        host, _, port = listen.rpartition(":")
        infos = socket.getaddrinfo(host.strip("[]"), int(port), type=socket.SOCK_STREAM)
        for family, _, _, _, place in infos[:1]:
            with socket.socket(family) as probe:
                # Remaining connections of a server that has just ended do not matter.
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind(place)
    except OSError as error:
        raise BadInput(f"cannot listen on {listen!r}: {error.strerror}") from error


def _found(address: str) -> list[ipaddress.IPv4Address | ipaddress.IPv6Address]:
    """Return the IP addresses to which the host of an address resolves; empty if it is unknown."""
    try:
        infos = socket.getaddrinfo(address.rpartition(":")[0].strip("[]"), None, type=socket.SOCK_STREAM)
    except OSError:
        return []
    return [ipaddress.ip_address(str(info[4][0]).partition("%")[0]) for info in infos]

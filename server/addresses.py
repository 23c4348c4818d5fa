"""Addresses to listen on: which texts are addresses, and who can reach them."""

import ipaddress
import socket
from pathlib import Path

from server.errors import BadInput

FORM = "host:port or unix:/path"
TCP_FORM = "host:port"


def is_address(text: str) -> bool:
    """Whether a text is `host:port` or `unix:/path`."""
    return (text.startswith("unix:") and text != "unix:") or is_tcp_address(text)


def is_tcp_address(text: str) -> bool:
    """Whether a text is `host:port`."""
    host, _, port = text.rpartition(":")
    return bool(host) and port.isascii() and port.isdecimal() and int(port) <= 65535


def is_loopback(address: str) -> bool:
    """Whether only this machine can reach what listens there."""
    return address.startswith("unix:") or (all(ip.is_loopback for ip in _found(address)) and bool(_found(address)))


def is_public(address: str) -> bool:
    """Whether anybody might reach what listens there: it is neither of this machine alone nor of a private network."""
    if address.startswith("unix:"):
        return False
    found = _found(address)
    return not found or any(ip.is_unspecified or not ip.is_private for ip in found)


def check_free(listen: str) -> None:
    """Makes sure that one can listen there: that nobody does, with a shared port either, and that it is this machine's.

    Raises:
        BadInput: if not; it says why.
    """
    try:
        if listen.startswith("unix:"):
            Path(listen.removeprefix("unix:")).parent.stat()
            return
        host, _, port = listen.rpartition(":")
        infos = socket.getaddrinfo(host.strip("[]"), int(port), type=socket.SOCK_STREAM)
        for family, _, _, _, place in infos[:1]:
            with socket.socket(family) as probe:
                # Connections of a server that has just ended are no hindrance.
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind(place)
    except OSError as error:
        raise BadInput(f"cannot listen on {listen!r}: {error.strerror}") from error


def _found(address: str) -> list[ipaddress.IPv4Address | ipaddress.IPv6Address]:
    """What a host's name stands for on this machine; nothing where it is not known."""
    try:
        infos = socket.getaddrinfo(address.rpartition(":")[0].strip("[]"), None, type=socket.SOCK_STREAM)
    except OSError:
        return []
    return [ipaddress.ip_address(str(info[4][0]).partition("%")[0]) for info in infos]

"""Serving over standard input and output, or over HTTP on this machine."""

import asyncio
import os
import signal
import socket
import sys
from collections.abc import Awaitable, Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import uvicorn
from mcp.server.lowlevel import Server
from mcp.server.stdio import stdio_server
from mcp.server.transport_security import TransportSecuritySettings

from arramon_client.errors import UsageError
from arramon_client.transport.access import host_of, is_local

PATH = "/mcp"
"""Path of the endpoint."""

LOCAL_HOSTS = ("127.0.0.1", "localhost", "[::1]")

STOP_SECONDS = 5
"""Longest wait for open connections when the HTTP server stops."""

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


async def serve_stdio(server: Server[Any], close: Callable[[], Awaitable[None]]) -> None:
    """Serve one client over standard input and output, until it closes the input.

    Args:
        server: the server.
        close: called before the process exits after a signal.
    """
    with _exiting_at_signals(close):
        async with stdio_server() as (incoming, outgoing):
            await server.run(incoming, outgoing, server.create_initialization_options())


async def serve_http(
    server: Server[Any], address: str, hosts: Sequence[str], origins: Sequence[str], listening: Callable[[str], None]
) -> None:
    """Serve any number of clients over streamable HTTP, until a signal arrives.

    No session is kept: a client notices nothing when the process is restarted. Requests must name this machine in
    `Host`, and those of web pages come from an origin on it: otherwise any web page could play by DNS rebinding.

    Args:
        server: the server.
        address: `host:port` of this machine; port 0 for a free one.
        hosts: further hosts to accept in `Host`, with any port, for a proxy.
        origins: further values of `Origin` to accept.
        listening: called with the URL when the server accepts connections.

    Raises:
        UsageError: if the address is not one of this machine, or cannot be used.
    """
    bound = _bound(address)
    app = server.streamable_http_app(
        streamable_http_path=PATH,
        stateless_http=True,
        json_response=True,
        transport_security=TransportSecuritySettings(
            allowed_hosts=[name for host in (*LOCAL_HOSTS, *hosts) for name in (host, f"{host}:*")],
            allowed_origins=[*(f"http://{host}:*" for host in LOCAL_HOSTS), *origins],
        ),
    )
    config = uvicorn.Config(app, log_level="warning", timeout_graceful_shutdown=STOP_SECONDS)
    host, port = bound.getsockname()[:2]
    listening(f"http://{f'[{host}]' if ':' in host else host}:{port}{PATH}")
    await uvicorn.Server(config).serve(sockets=[bound])


def _bound(address: str) -> socket.socket:
    host, _, port = address.rpartition(":")
    if not (host and port.isascii() and port.isdigit() and int(port) < 2**16):
        raise UsageError(f"--http is {address!r}, expected HOST:PORT, such as 127.0.0.1:8300")
    if not is_local(address):
        raise UsageError(
            f"--http {address} can be reached from other machines, whose users would play with your token: use "
            f"127.0.0.1:{port}, behind a proxy with authentication if needed (see --allow-host)"
        )
    host = host_of(address)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        bound = socket.create_server((host, int(port)), family=family)
    except OSError as error:
        raise UsageError(f"--http {address} cannot be used: {error.strerror or error}") from error
    # For its connections: otherwise the second part of an answer waits 40 ms until the first is acknowledged.
    bound.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return bound


@contextmanager
def _exiting_at_signals(close: Callable[[], Awaitable[None]]) -> Iterator[None]:
    """Exit in order when a signal arrives: the thread that waits for input cannot be interrupted in any other way."""
    if os.name != "posix":
        yield
        return
    loop = asyncio.get_running_loop()
    closing: list[asyncio.Task[None]] = []

    async def leave(number: int) -> None:
        try:
            await close()
        finally:
            sys.stderr.flush()
            os._exit(128 + number)

    def begin(number: int) -> None:
        if not closing:
            closing.append(loop.create_task(leave(number)))

    for number in SIGNALS:
        loop.add_signal_handler(number, begin, number)
    try:
        yield
    finally:
        for number in SIGNALS:
            loop.remove_signal_handler(number)

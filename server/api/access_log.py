"""Access log: a log line and a metric for each call, with its method, status, duration and account."""

import asyncio
import ipaddress
import logging
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import aclosing, contextmanager
from typing import Any
from urllib.parse import unquote

import grpc

from arramon_server.api.authentication import current_caller
from arramon_server.api.interceptor import Context, Continuation, Handler, HandlerFunction, wrap_handler

_QUIET = ("/grpc.health.", "/grpc.reflection.")

CANCELLED = grpc.StatusCode.CANCELLED.name

_log = logging.getLogger(__name__)


class AccessLog(grpc.aio.ServerInterceptor):
    """Interceptor that logs and counts each call when it ends. It comes before all others but `Responses`.

    Args:
        count: called with the method and the status of each call.
    """

    def __init__(self, count: Callable[[str, str], None]) -> None:
        self._count = count

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Wrap the call's handler."""
        handler = await continuation(handler_call_details)
        if handler is None:
            self._count("unknown", grpc.StatusCode.UNIMPLEMENTED.name)
            return None
        method = handler_call_details.method

        async def answer(work: HandlerFunction, request: Any, context: Context) -> Any:
            with self._log_end(method, context):
                return await work(request, context)

        async def stream(work: HandlerFunction, requests: Any, context: Context) -> AsyncIterator[Any]:
            with self._log_end(method, context):
                async with aclosing(work(requests, context)) as responses:
                    async for response in responses:
                        yield response

        return wrap_handler(handler, answer, stream)

    @contextmanager
    def _log_end(self, method: str, context: Context) -> Iterator[None]:
        started, peer, gone = time.monotonic(), context.peer(), False
        try:
            yield
        except (asyncio.CancelledError, GeneratorExit):  # the client has left, or its deadline has passed
            gone = True
            raise
        finally:
            self._write(method, CANCELLED if gone else _status(context), started, peer)

    def _write(self, method: str, status: str, started: float, peer: str) -> None:
        self._count(method.rpartition("/")[2], status)
        level = logging.DEBUG if method.startswith(_QUIET) else logging.INFO
        if _log.isEnabledFor(level):
            fields = {
                "method": method,
                "status": status,
                "seconds": round(time.monotonic() - started, 6),
                "account": _account(),
                "peer": network_of(peer),
            }
            _log.log(level, "call ended", extra=fields)


def network_of(peer: str) -> str:
    """Return the network (/24 or /48) of a peer's address, so that logs do not identify the peer; or "unix"."""
    kind, _, address = unquote(peer).partition(":")
    if kind not in ("ipv4", "ipv6"):
        return kind or "unknown"  # gRPC knows no address if the client had left already
    ip = ipaddress.ip_address(address.rpartition(":")[0].strip("[]").partition("%")[0])
    return str(ipaddress.ip_network((ip, 24 if ip.version == 4 else 48), strict=False))


def _status(context: Context) -> str:
    code = context.code()
    if not code:
        return grpc.StatusCode.OK.name
    return code.name if isinstance(code, grpc.StatusCode) else str(code)


def _account() -> str:
    try:
        caller = current_caller()
    except LookupError:
        return "unknown"
    return caller.account or caller.role.value

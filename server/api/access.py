"""A line in the log, and a count, for each call: method, status, how long it took, who called."""

import ipaddress
import logging
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import unquote

import grpc

from server.api.authentication import caller_of
from server.api.wrapping import Context, Continuation, Handler, Work, wrapped

_QUIET = ("/grpc.health.", "/grpc.reflection.")

_log = logging.getLogger(__name__)


class Access(grpc.aio.ServerInterceptor):
    """Stands before all other interceptors, and sees how each call ends.

    Args:
        count: told of each call's method and status.
    """

    def __init__(self, count: Callable[[str, str], None]) -> None:
        self._count = count

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Puts itself around the call's handler."""
        handler = await continuation(handler_call_details)
        if handler is None:
            self._count("unknown", grpc.StatusCode.UNIMPLEMENTED.name)
            return None
        method = handler_call_details.method

        async def answer(work: Work, request: Any, context: Context) -> Any:
            with self._seen(method, context):
                return await work(request, context)

        async def stream(work: Work, requests: Any, context: Context) -> AsyncIterator[Any]:
            with self._seen(method, context):
                async for response in work(requests, context):
                    yield response

        return wrapped(handler, answer, stream)

    @contextmanager
    def _seen(self, method: str, context: Context) -> Iterator[None]:
        started = time.monotonic()
        try:
            yield
        finally:
            self._ended(method, context, started)

    def _ended(self, method: str, context: Context, started: float) -> None:
        status = _status(context)
        self._count(method.rpartition("/")[2], status)
        level = logging.DEBUG if method.startswith(_QUIET) else logging.INFO
        if _log.isEnabledFor(level):
            fields = {
                "method": method,
                "status": status,
                "seconds": round(time.monotonic() - started, 6),
                "account": _account(context),
                "peer": network_of(context.peer()),
            }
            _log.log(level, "call ended", extra=fields)


def network_of(peer: str) -> str:
    """Where a call came from, without saying from whom: the network of its address, or "unix"."""
    kind, _, address = unquote(peer).partition(":")
    if kind not in ("ipv4", "ipv6"):
        return kind
    ip = ipaddress.ip_address(address.rpartition(":")[0].strip("[]").partition("%")[0])
    return str(ipaddress.ip_network((ip, 24 if ip.version == 4 else 48), strict=False))


def _status(context: Context) -> str:
    if context.cancelled():
        return grpc.StatusCode.CANCELLED.name
    code = context.code()
    if not code:
        return grpc.StatusCode.OK.name
    return code.name if isinstance(code, grpc.StatusCode) else str(code)


def _account(context: Context) -> str:
    try:
        caller = caller_of(context)
    except LookupError:
        return "unknown"
    return caller.account or caller.role.value

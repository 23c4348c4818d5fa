"""Error guard: an interceptor that turns every exception into a gRPC status that reveals no internals."""

import logging
from collections.abc import AsyncIterator, Callable
from contextlib import aclosing
from typing import Any

import grpc
from google.protobuf.message import DecodeError

from arramon_server.api.grpc_status import status_of
from arramon_server.api.interceptor import Context, Continuation, Handler, HandlerFunction, cancel_if_gone, wrap_handler
from arramon_server.errors import ArraMonError, BadInput, StorageError

INTERNAL_ERROR_TEXT = "internal server error: a defect of the server; its host finds the details in the server's log"
"""The only text that a caller receives for an unexpected error."""

STORAGE_ERROR_TEXT = "the server cannot reach its journal at the moment; no recorded step is lost; try again"
"""The only text that a caller receives for a storage error; the error's own message names hosts, paths and queries."""

MAX_TEXT_BYTES = 4096
"""Maximum size of an error's text on the wire, in bytes: clients accept 8 KiB of metadata in total."""

_log = logging.getLogger(__name__)


class UnreadableRequest(BadInput):
    """The bytes of a request are not a message of the expected type."""


class ErrorGuard(grpc.aio.ServerInterceptor):
    """Interceptor that answers unreadable requests with INVALID_ARGUMENT and unexpected errors with INTERNAL.

    Without it a caller would receive the exception's Python class and message, as UNKNOWN.
    """

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Wrap the call's handler."""
        handler = await continuation(handler_call_details)
        if handler is None:
            return None
        method = handler_call_details.method
        reads_many = handler.request_streaming

        async def answer(work: HandlerFunction, request: Any, context: Context) -> Any:
            try:
                with cancel_if_gone():  # a handler may write to the context directly
                    return await work(
                        _readable_requests(request) if reads_many else _require_readable(request), context
                    )
            except Exception as error:  # noqa: BLE001 - every exception is logged and answered
                await _refuse(error, context, method)

        async def stream(work: HandlerFunction, request: Any, context: Context) -> AsyncIterator[Any]:
            try:
                checked = _readable_requests(request) if reads_many else _require_readable(request)
                async with aclosing(work(checked, context)) as responses:
                    async for response in responses:
                        yield response
            except Exception as error:  # noqa: BLE001 - as above
                await _refuse(error, context, method)

        return wrap_handler(handler, answer, stream, read=_request_deserializer(handler.request_deserializer))


def _request_deserializer(deserialize: Callable[[bytes], Any] | None) -> Callable[[bytes], Any]:
    """Return a deserializer that returns `UnreadableRequest` instead of raising: gRPC would send the bare exception."""

    def read(data: bytes) -> Any:
        try:
            return data if deserialize is None else deserialize(data)
        except DecodeError as error:
            return UnreadableRequest(f"the request cannot be read: {error}")

    return read


async def _readable_requests(requests: AsyncIterator[Any]) -> AsyncIterator[Any]:
    async for request in requests:
        yield _require_readable(request)


def _require_readable(request: Any) -> Any:
    if isinstance(request, UnreadableRequest):
        raise request
    return request


async def _refuse(error: Exception, context: Context, method: str) -> None:
    """End a call with the status of an error.

    Raises:
        AbortError: unless the client has left; this is how gRPC ends a call.
        CancelledError: if the client has left.
    """
    if isinstance(error, grpc.aio.AbortError):
        raise error
    if isinstance(error, StorageError):
        _log.error("%s failed: %s", method, error)
        code, text = grpc.StatusCode.UNAVAILABLE, STORAGE_ERROR_TEXT
    elif isinstance(error, ArraMonError):
        code, text = status_of(error), str(error)
    else:
        _log.error("%s failed", method, exc_info=error)
        code, text = grpc.StatusCode.INTERNAL, INTERNAL_ERROR_TEXT
    with cancel_if_gone():
        await context.abort(code, truncate_status(text))


def truncate_status(text: str) -> str:
    """Return an error's text, cut to `MAX_TEXT_BYTES` bytes on the wire: clients cannot read a longer status.

    In a status, each byte that is not a printable ASCII character takes three bytes.
    """
    size = 0
    for place, letter in enumerate(text):
        size += 1 if " " <= letter <= "~" and letter != "%" else 3 * len(letter.encode(errors="replace"))
        if size > MAX_TEXT_BYTES:
            return text[:place] + "..."
    return text

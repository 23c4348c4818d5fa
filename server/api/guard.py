"""Stands before every call: what cannot be read is refused, and what breaks inside tells nothing of the inside."""

import logging
from collections.abc import AsyncIterator, Callable
from typing import Any

import grpc
from google.protobuf.message import DecodeError

from server.api.status import status_of
from server.api.wrapping import Context, Continuation, Handler, Work, wrapped
from server.errors import ArraMonError, BadInput, StorageError

BROKEN = "the server failed at this; it is a defect of the server, and its host can find it in the log"
"""All that a caller is told of an error that nobody foresaw."""

AWAY = "the server cannot reach its journal just now; nothing that was answered is lost, try again"
"""All that a caller is told of the storage: its own words name hosts, paths and queries."""

_log = logging.getLogger(__name__)


class Unreadable(BadInput):
    """The bytes that came are no message of the kind expected."""


class Guard(grpc.aio.ServerInterceptor):
    """Turns bytes that are no message into INVALID_ARGUMENT, and errors that nobody foresaw into INTERNAL.

    Without it a caller would be shown the error's Python class and words, under UNKNOWN.
    """

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Puts itself around the call's handler."""
        handler = await continuation(handler_call_details)
        if handler is None:
            return None
        method = handler_call_details.method
        reads_many = handler.request_streaming

        async def answer(work: Work, request: Any, context: Context) -> Any:
            try:
                return await work(_readable(request) if reads_many else _checked(request), context)
            except Exception as error:  # noqa: BLE001 - whatever it is, it is logged and answered
                await _refuse(error, context, method)

        async def stream(work: Work, request: Any, context: Context) -> AsyncIterator[Any]:
            try:
                async for response in work(_readable(request) if reads_many else _checked(request), context):
                    yield response
            except Exception as error:  # noqa: BLE001 - as above
                await _refuse(error, context, method)

        return wrapped(handler, answer, stream, read=_reader(handler.request_deserializer))


def _reader(deserialize: Callable[[bytes], Any] | None) -> Callable[[bytes], Any]:
    """As `deserialize`, but what cannot be read becomes a value: an error there would reach the caller as it is."""

    def read(data: bytes) -> Any:
        try:
            return data if deserialize is None else deserialize(data)
        except DecodeError as error:
            return Unreadable(f"the request cannot be read: {error}")

    return read


async def _readable(requests: AsyncIterator[Any]) -> AsyncIterator[Any]:
    async for request in requests:
        yield _checked(request)


def _checked(request: Any) -> Any:
    if isinstance(request, Unreadable):
        raise request
    return request


async def _refuse(error: Exception, context: Context, method: str) -> None:
    """Ends a call with the status that an error stands for.

    Raises:
        AbortError: always, as gRPC ends calls by it.
    """
    if isinstance(error, grpc.aio.AbortError):
        raise error
    if isinstance(error, StorageError):
        _log.error("%s failed: %s", method, error)
        await context.abort(grpc.StatusCode.UNAVAILABLE, AWAY)
    if isinstance(error, ArraMonError):
        await context.abort(status_of(error), str(error))
    _log.error("%s failed", method, exc_info=error)
    await context.abort(grpc.StatusCode.INTERNAL, BROKEN)

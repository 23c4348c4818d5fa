"""Helpers for interceptors: wrapping the handler of any kind of call, and the origin of a call.

A context's connection data (peer, metadata, authentication) lies in gRPC's own memory, which is freed when the call
ends: `CallOrigin` copies it once, when the call starts, and it must not be read from the context later.
"""

import asyncio
import inspect
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

import grpc

Context: TypeAlias = "grpc.aio.ServicerContext[Any, Any]"  # subscripts for the type checker alone
Handler: TypeAlias = "grpc.RpcMethodHandler[Any, Any]"
Continuation: TypeAlias = Callable[[grpc.HandlerCallDetails], Awaitable["Handler | None"]]

HandlerFunction: TypeAlias = Callable[[Any, Context], Any]
"""A handler's function. It takes the request, or an iterator over the requests, and the call's context."""


@dataclass(frozen=True, slots=True)
class CallOrigin:
    """Connection and metadata of a call.

    Attributes:
        peer: the client's address, as gRPC writes it.
        encrypted: whether the connection is encrypted.
        metadata: metadata sent by the client.
    """

    peer: str
    encrypted: bool
    metadata: tuple[tuple[str, str | bytes], ...]

    @classmethod
    def of(cls, context: Context) -> "CallOrigin":
        """Return the origin of a call that has just begun. For an ended call, gRPC would crash the process."""
        encrypted = context.auth_context().get("transport_security_type") == [b"ssl"]
        return cls(
            context.peer(), encrypted, tuple((str(key), value) for key, value in context.invocation_metadata() or ())
        )


UnaryWrapper: TypeAlias = Callable[[HandlerFunction, Any, Context], Awaitable[Any]]
StreamWrapper: TypeAlias = Callable[[HandlerFunction, Any, Context], AsyncIterator[Any]]


def wrap_handler(
    handler: Handler, answer: UnaryWrapper, stream: StreamWrapper, *, read: Callable[[bytes], Any] | None = None
) -> Handler:
    """Return a handler of the same kind that wraps the given one.

    Args:
        handler: handler of any kind of call.
        answer: wraps handlers that return one response, or that write their responses to the context.
        stream: wraps handlers that yield their responses. It must be an asynchronous generator function, not a method:
            gRPC inspects it, and does not recognise a bound method with its first argument applied.
        read: deserializes requests; None for the handler's own deserializer.
    """
    kinds: dict[tuple[bool, bool], tuple[Any, Any]] = {
        (False, False): (handler.unary_unary, grpc.unary_unary_rpc_method_handler),
        (False, True): (handler.unary_stream, grpc.unary_stream_rpc_method_handler),
        (True, False): (handler.stream_unary, grpc.stream_unary_rpc_method_handler),
        (True, True): (handler.stream_stream, grpc.stream_stream_rpc_method_handler),
    }
    work, make = kinds[bool(handler.request_streaming), bool(handler.response_streaming)]
    around = stream if inspect.isasyncgenfunction(work) else answer
    made: Handler = make(partial(around, work), read or handler.request_deserializer, handler.response_serializer)
    return made


@contextmanager
def cancel_if_gone() -> Iterator[None]:
    """Raise CancelledError if the client leaves while the block sends to it, instead of gRPC's InternalError.

    Raises:
        CancelledError: if the client has left.
    """
    try:
        yield
    except grpc.aio.InternalError as error:
        raise asyncio.CancelledError from error

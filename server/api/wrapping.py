"""Puts work around the handler of a call, whatever kind of call it is: what the interceptors have in common."""

import inspect
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial
from typing import Any, TypeAlias

import grpc

Context: TypeAlias = "grpc.aio.ServicerContext[Any, Any]"  # subscripts for the type checker alone
Handler: TypeAlias = "grpc.RpcMethodHandler[Any, Any]"
Continuation: TypeAlias = Callable[[grpc.HandlerCallDetails], Awaitable["Handler | None"]]

Work: TypeAlias = Callable[[Any, Context], Any]
"""A handler's own function: of the request, or of an iterator over the requests, and the call's context."""

Answer: TypeAlias = Callable[[Work, Any, Context], Awaitable[Any]]
Stream: TypeAlias = Callable[[Work, Any, Context], AsyncIterator[Any]]


def wrapped(handler: Handler, answer: Answer, stream: Stream, *, read: Callable[[bytes], Any] | None = None) -> Handler:
    """A handler of the same kind that does more than the given one.

    Args:
        handler: of any kind of call.
        answer: awaits the handler's function, for calls with one response, and for those that write their responses
            to the context.
        stream: yields what the handler's function yields. It is an asynchronous generator function and no method: gRPC
            looks for that, and Python does not see it of a method that has been given its first argument.
        read: reads requests; the handler's own way where it is None.
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

"""Writes streamed responses, and closes their generator before gRPC releases the call."""

import inspect
from collections.abc import Callable
from contextlib import aclosing
from typing import Any

import grpc

from arramon_server.api.interceptor import Context, Continuation, Handler, cancel_if_gone


class ResponseWriter(grpc.aio.ServerInterceptor):
    """Interceptor that writes the responses of streaming calls. It must come before all others.

    If gRPC wrote them, and a call ended while a response is being written, only the garbage collector would close its
    generator, after gRPC has released the call: any use of the context by the generator would then crash the process.
    """

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Wrap the call's handler."""
        handler = await continuation(handler_call_details)
        if handler is None or not handler.response_streaming:
            return handler
        work = handler.stream_stream if handler.request_streaming else handler.unary_stream
        if not inspect.isasyncgenfunction(work):
            return handler  # It writes its responses to the context directly.

        async def write(requests: Any, context: Context) -> None:
            async with aclosing(work(requests, context)) as responses:
                async for response in responses:
                    with cancel_if_gone():
                        await context.write(response)

        many = handler.request_streaming
        make: Any = grpc.stream_stream_rpc_method_handler if many else grpc.unary_stream_rpc_method_handler
        made: Handler = make(write, handler.request_deserializer, _serializer(handler.response_serializer))
        return made


def _serializer(serialize: Callable[[Any], bytes] | None) -> Callable[[Any], bytes]:
    """Return a serializer that also accepts responses that are serialized already."""

    def write(response: Any) -> bytes:
        if isinstance(response, bytes) or serialize is None:
            return bytes(response)
        return serialize(response)

    return write

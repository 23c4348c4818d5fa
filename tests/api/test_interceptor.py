"""Interceptors: they wrap every kind of gRPC call without changing its answers."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import grpc
import pytest

from arramon_server.api.interceptor import Context, Continuation, Handler, HandlerFunction, wrap_handler


class Noting(grpc.aio.ServerInterceptor):
    """Notes the method of every call before and after it."""

    def __init__(self) -> None:
        self.noted: list[str] = []

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        handler = await continuation(handler_call_details)
        assert handler is not None
        method = handler_call_details.method

        async def answer(work: HandlerFunction, request: Any, context: Context) -> Any:
            self.noted.append(f"{method} answers")
            response = await work(request, context)
            self.noted.append("ended")
            return response

        async def stream(work: HandlerFunction, request: Any, context: Context) -> AsyncIterator[Any]:
            self.noted.append(f"{method} streams")
            async for response in work(request, context):
                yield response
            self.noted.append("ended")

        return wrap_handler(handler, answer, stream)


async def one_to_one(request: bytes, _: Context) -> bytes:
    return request


async def one_to_many(request: bytes, _: Context) -> AsyncIterator[bytes]:
    for _again in range(2):
        yield request


async def one_to_many_written(request: bytes, context: Context) -> None:
    for _again in range(2):
        await context.write(request)


async def many_to_one(requests: AsyncIterator[bytes], _: Context) -> bytes:
    return b"".join([request async for request in requests])


async def many_to_many(requests: AsyncIterator[bytes], _: Context) -> AsyncIterator[bytes]:
    async for request in requests:
        yield request


HANDLERS: dict[str, Any] = {
    "one_to_one": grpc.unary_unary_rpc_method_handler(one_to_one),
    "one_to_many": grpc.unary_stream_rpc_method_handler(one_to_many),
    "one_to_many_written": grpc.unary_stream_rpc_method_handler(one_to_many_written),
    "many_to_one": grpc.stream_unary_rpc_method_handler(many_to_one),
    "many_to_many": grpc.stream_stream_rpc_method_handler(many_to_many),
}


@pytest.mark.parametrize(
    ("method", "answered", "noted"),
    [
        ("one_to_one", [b"a"], "answers"),
        ("one_to_many", [b"a", b"a"], "streams"),
        ("one_to_many_written", [b"a", b"a"], "answers"),
        ("many_to_one", [b"ab"], "answers"),
        ("many_to_many", [b"a", b"b"], "streams"),
    ],
)
def test_interceptors_wrap_every_kind_of_call(method: str, answered: list[bytes], noted: str) -> None:
    outer, inner = Noting(), Noting()

    async def called() -> list[bytes]:
        server = grpc.aio.server(interceptors=[outer, inner])
        server.add_generic_rpc_handlers([grpc.method_handlers_generic_handler("kinds", HANDLERS)])
        port = server.add_insecure_port("127.0.0.1:0")
        await server.start()
        async with grpc.aio.insecure_channel(f"127.0.0.1:{port}") as channel:
            try:
                return await _call(channel, method)
            finally:
                await server.stop(None)

    assert asyncio.run(called()) == answered
    assert outer.noted == inner.noted == [f"/kinds/{method} {noted}", "ended"]


async def _call(channel: Any, method: str) -> list[bytes]:
    path = f"/kinds/{method}"
    if method == "one_to_one":
        return [await channel.unary_unary(path)(b"a")]
    if method == "many_to_one":
        return [await channel.stream_unary(path)(iter([b"a", b"b"]))]
    if method == "many_to_many":
        return [response async for response in channel.stream_stream(path)(iter([b"a", b"b"]))]
    return [response async for response in channel.unary_stream(path)(b"a")]

"""Turns away clients that speak another protocol, before anything else is said."""

from typing import Any

import grpc

from arramon.v1 import PROTOCOL, PROTOCOL_METADATA
from server import __version__
from server.api.wrapping import Context, Continuation, Handler


class VersionCheck(grpc.aio.ServerInterceptor):
    """Refuses calls to this project's services that do not name this server's protocol."""

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Lets the call through, or puts a refusal in its place."""
        handler = await continuation(handler_call_details)
        if handler is None or not handler_call_details.method.startswith("/arramon."):
            return handler
        metadata = dict(handler_call_details.invocation_metadata or ())
        spoken = metadata.get(PROTOCOL_METADATA, "none")
        if spoken == str(PROTOCOL):
            return handler
        message = (
            f"this server ({__version__}) speaks protocol {PROTOCOL}, the client {spoken!r}; "
            f"install the arramon-client that belongs to the server"
        )

        async def refuse(_request: Any, context: Context) -> None:
            await context.abort(grpc.StatusCode.FAILED_PRECONDITION, message)

        if handler.request_streaming:
            return grpc.stream_unary_rpc_method_handler(refuse)
        return grpc.unary_unary_rpc_method_handler(refuse)

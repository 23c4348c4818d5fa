"""Check of the protocol version of every call."""

from typing import Any

import grpc

from arramon.v1 import PROTOCOL, PROTOCOL_METADATA
from arramon_server import __version__
from arramon_server.api.interceptor import Context, Continuation, Handler
from arramon_server.errors import quoted


class VersionCheck(grpc.aio.ServerInterceptor):
    """Interceptor that refuses calls to this project's services that do not state this server's protocol number."""

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> "Handler | None":
        """Return the call's handler, or one that refuses the call."""
        handler = await continuation(handler_call_details)
        if handler is None or not handler_call_details.method.startswith("/arramon."):
            return handler
        metadata = dict(handler_call_details.invocation_metadata or ())
        client_protocol = metadata.get(PROTOCOL_METADATA, "none")
        if client_protocol == str(PROTOCOL):
            return handler
        message = (
            f"this server ({__version__}) speaks protocol {PROTOCOL}, the client {quoted(str(client_protocol))}; "
            f"install the arramon-client of the server's version"
        )

        async def refuse(_request: Any, context: Context) -> None:
            await context.abort(grpc.StatusCode.FAILED_PRECONDITION, message)

        if handler.request_streaming:
            return grpc.stream_unary_rpc_method_handler(refuse)
        return grpc.unary_unary_rpc_method_handler(refuse)

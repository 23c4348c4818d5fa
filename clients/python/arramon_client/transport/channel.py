"""gRPC channels to a server on which every call carries the participant's token."""

from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import grpc

from arramon_client.transport.access import Access


class _Details(NamedTuple):
    """Details of a call, with the fields that gRPC requires of an interceptor."""

    method: str
    timeout: float | None
    metadata: Any
    credentials: grpc.CallCredentials | None
    wait_for_ready: bool | None
    compression: grpc.Compression | None


class _Bearer(grpc.UnaryUnaryClientInterceptor, grpc.StreamStreamClientInterceptor):
    """Interceptor that adds the token to every call, as gRPC's call credentials do not work without TLS."""

    def __init__(self, token: str) -> None:
        self._metadata = (("authorization", f"Bearer {token}"),)

    def intercept_unary_unary(self, continuation: Any, client_call_details: Any, request: Any) -> Any:
        return continuation(self._with_token(client_call_details), request)

    def intercept_stream_stream(self, continuation: Any, client_call_details: Any, request_iterator: Any) -> Any:
        return continuation(self._with_token(client_call_details), request_iterator)

    def _with_token(self, details: Any) -> grpc.ClientCallDetails:
        made = _Details(
            details.method,
            details.timeout,
            (*(details.metadata or ()), *self._metadata),
            details.credentials,
            details.wait_for_ready,
            details.compression,
        )
        return cast(grpc.ClientCallDetails, made)


def open_channel(address: str, access: Access, options: Sequence[tuple[str, Any]]) -> grpc.Channel:
    """Open a channel to a server on which every call carries the token.

    Raises:
        UsageError: if the token would be sent to another machine without encryption.
    """
    if access.encrypts(address):
        name = (("grpc.ssl_target_name_override", access.name),) if access.name else ()
        credentials = grpc.ssl_channel_credentials(access.authority)
        channel = grpc.secure_channel(address, credentials, options=(*options, *name))
    else:
        channel = grpc.insecure_channel(address, options=options)
    return grpc.intercept_channel(channel, _Bearer(access.token)) if access.token else channel

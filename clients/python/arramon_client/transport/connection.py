"""Connection to a server: channel options, the protocol version on every call, and translation of gRPC errors."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple, TypeVar

import grpc
from google.protobuf.message import Message

from arramon.v1 import PROTOCOL, PROTOCOL_METADATA, evaluation_pb2, evaluation_pb2_grpc
from arramon_client.closing import close_once
from arramon_client.errors import (
    ArramonClientError,
    EncryptionError,
    MessageTooLargeError,
    NotArramonError,
    ProtocolError,
    RefusedError,
    ServerUnreachableError,
    VersionMismatchError,
)
from arramon_client.printable import one_line
from arramon_client.transport.access import VARIABLE, Access
from arramon_client.transport.channel import open_channel
from arramon_client.transport.incoming import check_and_clean, details_of

Answer = TypeVar("Answer")

METADATA = ((PROTOCOL_METADATA, str(PROTOCOL)),)
"""Metadata sent with every call: the client's protocol version."""

NO_TOKEN = Access()
"""Access without a token."""

MAX_MESSAGE_BYTES = 64 * 1024 * 1024

CHANNEL_OPTIONS = (
    ("grpc.max_receive_message_length", MAX_MESSAGE_BYTES),
    ("grpc.max_send_message_length", MAX_MESSAGE_BYTES),
    ("grpc.keepalive_time_ms", 60_000),
    ("grpc.keepalive_timeout_ms", 20_000),
    # Reconnect to a restarted server within seconds; gRPC's default backs off for up to two minutes.
    ("grpc.initial_reconnect_backoff_ms", 100),
    ("grpc.min_reconnect_backoff_ms", 1_000),
    ("grpc.max_reconnect_backoff_ms", 2_000),
)

READS = ("Get", "List", "Compare", "Export")
"""Beginnings of the names of requests that change nothing, so that they can be repeated."""

CHANNEL_CLOSED = "Channel closed!"
"""What gRPC says of a call that ended because this client closed its channel."""

UNARY_TIMEOUT = 60.0
"""Default time limit of a unary call, in seconds."""

CONNECTION_LOST = frozenset({
    grpc.StatusCode.UNAVAILABLE,
    grpc.StatusCode.ABORTED,
    grpc.StatusCode.CANCELLED,
    grpc.StatusCode.DEADLINE_EXCEEDED,
    grpc.StatusCode.INTERNAL,
    grpc.StatusCode.UNKNOWN,
})  # fmt: skip
"""Statuses of a stream whose connection or server was lost; reconnecting may help."""


ENCRYPTION = {
    "WRONG_VERSION_NUMBER": "it does not use TLS, or is not an ArraMon server",
    "Hostname Verification": "its certificate is for another name: connect to that name",
    "SSL_ERROR_SSL": "its certificate is not trusted; if its host gave you a certificate, use --tls-ca FILE",
}
"""Advice for failed encryption, by a substring of gRPC's message."""

ADVICE = ENCRYPTION | {"Socket closed": "if it uses TLS, add --tls"}
"""Advice for a server that does not answer, by a substring of gRPC's message; a stopping server closes sockets, too."""


class Server(NamedTuple):
    """A connected server.

    Attributes:
        stub: stub of the Evaluation service.
        info: the server's information.
        address: address as the participant wrote it.
        channel: the open channel, for the stubs of further services.
        access: credentials and encryption of the connection.
    """

    stub: evaluation_pb2_grpc.EvaluationStub
    info: evaluation_pb2.ServerInfo
    address: str
    channel: grpc.Channel
    access: Access


def raise_unreachable(error: ServerUnreachableError) -> None:
    """Raise the error, so that `connect` does not try again."""
    raise error


@contextmanager
def connect(
    address: str,
    access: Access = NO_TOKEN,
    *,
    timeout: float = 15.0,
    unreachable: Callable[[ServerUnreachableError], None] = raise_unreachable,
) -> Iterator[Server]:
    """Open a channel and get the server's information; close the channel at the end of the context, or of the program.

    Args:
        address: `host:port` or `unix:/path`.
        access: the participant's token, and the encryption of the connection.
        timeout: seconds to wait for the first answer.
        unreachable: called if no server answers; raises the error, or returns to try again.

    Raises:
        UsageError: if the token would be sent to another machine without encryption.
        EncryptionError: if the server does not use TLS, or its certificate is not trusted.
        ServerUnreachableError: if no server answers and `unreachable` raises it.
        NotArramonError: if the program that answers is not an ArraMon server.
        VersionMismatchError: if the server speaks another protocol.
        RefusedError: if the server does not accept the token.
        ProtocolError: if its information is malformed.
    """
    channel = open_channel(address, access, CHANNEL_OPTIONS)
    stub = evaluation_pb2_grpc.EvaluationStub(channel)
    close = close_once(stub, channel.close)  # It waits for the channel's thread until all calls have ended.
    try:
        info = None
        while info is None:
            try:
                info = get_server_info(stub, address, timeout)
            except EncryptionError:
                raise
            except ServerUnreachableError as error:
                unreachable(error)
        yield Server(stub, info, address, channel, access)
    finally:
        close()


def get_server_info(
    stub: evaluation_pb2_grpc.EvaluationStub, address: str, timeout: float = 15.0
) -> evaluation_pb2.ServerInfo:
    """Return the server's information after checking that it speaks this client's protocol.

    Raises:
        ServerUnreachableError, NotArramonError, VersionMismatchError, RefusedError, ProtocolError: as for `connect`.
    """
    try:
        info = _answer(stub.GetServerInfo, evaluation_pb2.GetServerInfoRequest(), timeout)
    except grpc.RpcError as error:
        if error.code() == grpc.StatusCode.FAILED_PRECONDITION:
            raise VersionMismatchError(f"the server at {address} refuses this client: {details_of(error)}") from error
        raise explain(error, address) from error
    if info.protocol != PROTOCOL:
        older = "this client" if info.protocol > PROTOCOL else "the server"
        raise VersionMismatchError(
            f"the server at {address} ({one_line(info.version, 100)}) speaks protocol {info.protocol}, this client "
            f"{PROTOCOL}: upgrade {older}"
        )
    return check_and_clean(info)


def call(method: Callable[..., Answer], request: object, address: str, *, timeout: float = UNARY_TIMEOUT) -> Answer:
    """Make a unary call, translate its errors, and check the answer (`incoming.check_and_clean`).

    Raises:
        ArramonClientError: the error that `explain` returns, or ProtocolError if the answer is malformed.
    """
    try:
        answer = _answer(method, request, timeout)
    except grpc.RpcError as error:
        raise explain(error, address) from error
    if isinstance(answer, Message):
        check_and_clean(answer)
    return answer


def _answer(method: Callable[..., Answer], request: object, timeout: float) -> Answer:
    """Make a unary call. A read that a draining process refused is repeated: the channel has left that process."""
    try:
        return method(request, timeout=timeout, metadata=METADATA)
    except grpc.RpcError as error:
        if not (_is_draining(error) and type(request).__name__.startswith(READS)):
            raise
    return method(request, timeout=timeout, metadata=METADATA)


def _is_draining(error: grpc.RpcError) -> bool:
    """Return whether the server process cancelled a call: gRPC does so with all that reach it while it drains."""
    return bool(error.code() == grpc.StatusCode.CANCELLED and error.details() != CHANNEL_CLOSED)


def explain(error: grpc.RpcError, address: str) -> ArramonClientError:
    """Return the client's error for a failed call, with a message for the participant."""
    code, details = error.code(), details_of(error)
    if _is_draining(error):
        return ServerUnreachableError(
            f"the server process at {address} is shutting down, and did not answer: try again ({details})"
        )
    match code:
        case grpc.StatusCode.UNAVAILABLE | grpc.StatusCode.DEADLINE_EXCEEDED:
            advice = next((advice for sign, advice in ADVICE.items() if sign in details), "")
            kind = EncryptionError if advice in ENCRYPTION.values() else ServerUnreachableError
            return kind(f"no server answers at {address}: {advice and advice + '; '}{details}")
        case grpc.StatusCode.UNIMPLEMENTED:
            return NotArramonError(f"the program at {address} is not an ArraMon server of this protocol: {details}")
        case grpc.StatusCode.RESOURCE_EXHAUSTED if "message" in details and ("larger" in details or "max" in details):
            return MessageTooLargeError(
                f"a message is too large ({details}): use a smaller --parallel or --image-size, or --encoding zstd",
                code,
            )
        case grpc.StatusCode.UNAUTHENTICATED:
            advice = f"the token is read from --token-file or ${VARIABLE}"
            return RefusedError(f"the server at {address} refused authentication: {details} ({advice})", code)
        case grpc.StatusCode.PERMISSION_DENIED:
            return RefusedError(f"the server at {address} denied permission: {details or 'no reason was given'}", code)
        case grpc.StatusCode.RESOURCE_EXHAUSTED:
            return RefusedError(f"a limit of the server at {address} is reached: {details}", code)
        case grpc.StatusCode.INTERNAL | grpc.StatusCode.UNKNOWN:
            return ProtocolError(f"the server at {address} failed: {details}")
        case _:
            return RefusedError(f"{details or 'no reason was given'} ({code.name})", code)

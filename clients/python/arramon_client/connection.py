"""The way to a server: the channel, the protocol's number on every call, and errors that a participant understands."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple, TypeVar

import grpc

from arramon.v1 import PROTOCOL, PROTOCOL_METADATA, evaluation_pb2, evaluation_pb2_grpc
from arramon_client.access import VARIABLE, Access, open_channel
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

Answer = TypeVar("Answer")

METADATA = ((PROTOCOL_METADATA, str(PROTOCOL)),)
"""Goes with every call."""

NOTHING = Access()
"""What those show who have no token."""

MAX_MESSAGE_BYTES = 64 * 1024 * 1024

CHANNEL_OPTIONS = (
    ("grpc.max_receive_message_length", MAX_MESSAGE_BYTES),
    ("grpc.max_send_message_length", MAX_MESSAGE_BYTES),
    ("grpc.keepalive_time_ms", 60_000),
    ("grpc.keepalive_timeout_ms", 20_000),
    # A server that restarts is to be found again within seconds; the default backs off for two minutes.
    ("grpc.initial_reconnect_backoff_ms", 100),
    ("grpc.min_reconnect_backoff_ms", 1_000),
    ("grpc.max_reconnect_backoff_ms", 2_000),
)

UNARY_TIMEOUT = 60.0
"""Seconds that a unary call may take."""

BROKEN = frozenset({
    grpc.StatusCode.UNAVAILABLE,
    grpc.StatusCode.ABORTED,
    grpc.StatusCode.CANCELLED,
    grpc.StatusCode.DEADLINE_EXCEEDED,
    grpc.StatusCode.INTERNAL,
    grpc.StatusCode.UNKNOWN,
})  # fmt: skip
"""Statuses with which a stream breaks when a connection or a server is lost: worth another try."""


ENCRYPTION = {
    "WRONG_VERSION_NUMBER": "it does not encrypt, or what answers there is no server",
    "Hostname Verification": "its certificate is for another name: connect to that name",
    "SSL_ERROR_SSL": "its certificate is not one to trust; if its host gave you one, use --tls-ca FILE",
}
"""What helps where encryption fails, by what gRPC says then."""

ADVICE = ENCRYPTION | {"Socket closed": "if it encrypts, use --tls"}
"""What may help where no server answers; a server that is just ending closes sockets too."""


class Server(NamedTuple):
    """A server that answered.

    Attributes:
        stub: to call it by.
        info: what it said of itself.
        address: as the participant wrote it.
        channel: on which it did; for the stubs of further services.
        access: that was shown to it.
    """

    stub: evaluation_pb2_grpc.EvaluationStub
    info: evaluation_pb2.ServerInfo
    address: str
    channel: grpc.Channel
    access: Access


def give_up(error: ServerUnreachableError) -> None:
    """Raises the error."""
    raise error


@contextmanager
def connect(
    address: str,
    access: Access = NOTHING,
    *,
    timeout: float = 15.0,
    unreachable: Callable[[ServerUnreachableError], None] = give_up,
) -> Iterator[Server]:
    """Opens a channel, asks the server who it is, and closes the channel at the end.

    Args:
        address: `host:port` or `unix:/path`.
        access: the participant's token, and how the connection is encrypted.
        timeout: seconds to wait for the first answer.
        unreachable: is told that nothing answers; where it returns, the server is asked again.

    Raises:
        UsageError: if the token would be readable on its way.
        EncryptionError: if what answers does not encrypt as it should.
        ServerUnreachableError: if nothing answers, as `unreachable` raises it.
        NotArramonError: if what answers is not an ArraMon server.
        VersionMismatchError: if it speaks another protocol.
        RefusedError: if it does not take the token.
    """
    channel = open_channel(address, access, CHANNEL_OPTIONS)
    try:
        stub = evaluation_pb2_grpc.EvaluationStub(channel)
        info = None
        while info is None:
            try:
                info = greet(stub, address, timeout)
            except EncryptionError:
                raise
            except ServerUnreachableError as error:
                unreachable(error)
        yield Server(stub, info, address, channel, access)
    finally:
        channel.close()


def greet(stub: evaluation_pb2_grpc.EvaluationStub, address: str, timeout: float = 15.0) -> evaluation_pb2.ServerInfo:
    """The server's information, once it is certain that it speaks this client's protocol.

    Raises:
        ServerUnreachableError, NotArramonError, VersionMismatchError, RefusedError: as `connect`.
    """
    try:
        info = stub.GetServerInfo(evaluation_pb2.GetServerInfoRequest(), timeout=timeout, metadata=METADATA)
    except grpc.RpcError as error:
        if error.code() == grpc.StatusCode.FAILED_PRECONDITION:
            raise VersionMismatchError(f"the server at {address} refuses this client: {error.details()}") from error
        raise explain(error, address) from error
    if info.protocol != PROTOCOL:
        older = "this client" if info.protocol > PROTOCOL else "the server"
        raise VersionMismatchError(
            f"the server at {address} ({info.version}) speaks protocol {info.protocol}, this client {PROTOCOL}: "
            f"{older} is to be upgraded"
        )
    return info


def call(method: Callable[..., Answer], request: object, address: str) -> Answer:
    """A unary call, with its errors explained.

    Raises:
        ArramonClientError: of the kind that `explain` finds.
    """
    try:
        return method(request, timeout=UNARY_TIMEOUT, metadata=METADATA)
    except grpc.RpcError as error:
        raise explain(error, address) from error


def explain(error: grpc.RpcError, address: str) -> ArramonClientError:
    """The error that a participant understands, for a call that failed."""
    code, details = error.code(), error.details() or ""
    match code:
        case grpc.StatusCode.UNAVAILABLE | grpc.StatusCode.DEADLINE_EXCEEDED:
            advice = next((advice for sign, advice in ADVICE.items() if sign in details), "")
            kind = EncryptionError if advice in ENCRYPTION.values() else ServerUnreachableError
            return kind(f"no server answers at {address}: {advice and advice + '; '}{details}")
        case grpc.StatusCode.UNIMPLEMENTED:
            return NotArramonError(f"what answers at {address} is not an ArraMon server of this protocol: {details}")
        case grpc.StatusCode.RESOURCE_EXHAUSTED if "message" in details and ("larger" in details or "max" in details):
            return MessageTooLargeError(
                f"a message is too large ({details}); ask for less at once: a smaller --parallel or --image-size, "
                "or --encoding zstd",
                code,
            )
        case grpc.StatusCode.UNAUTHENTICATED:
            advice = f"the token is read from --token-file or ${VARIABLE}"
            return RefusedError(f"the server at {address} does not let you in: {details} ({advice})", code)
        case grpc.StatusCode.PERMISSION_DENIED:
            return RefusedError(
                f"the server at {address} does not permit that: {details or 'it gives no reason'}", code
            )
        case grpc.StatusCode.RESOURCE_EXHAUSTED:
            return RefusedError(f"the server at {address} grants no more: {details}", code)
        case grpc.StatusCode.INTERNAL | grpc.StatusCode.UNKNOWN:
            return ProtocolError(f"the server at {address} failed: {details}")
        case _:
            return RefusedError(f"{details or 'no reason was given'} ({code.name})", code)

"""How a participant gets in: the token, whether the connection is encrypted, and the options that say so."""

import argparse
import ipaddress
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, cast

import grpc

from arramon_client.errors import UsageError

VARIABLE = "ARRAMON_TOKEN"
"""The environment variable with the token."""


@dataclass(frozen=True, slots=True)
class Access:
    """What is shown to a server.

    Attributes:
        token: none where it is empty.
        tls: whether the connection is encrypted; None: where a token goes to another machine.
        authority: PEM certificates that are trusted instead of the public authorities'; with them it is encrypted.
        name: of the server, as its certificate has it, where that is not the address.
    """

    token: str = field(default="", repr=False)
    tls: bool | None = None
    authority: bytes | None = None
    name: str = ""

    def encrypts(self, address: str) -> bool:
        """Whether a connection to an address is encrypted.

        Raises:
            UsageError: if a token would be readable on its way to another machine.
        """
        local = is_local(address)
        tls = self.tls
        if tls is None:
            tls = self.authority is not None or bool(self.token and not local)
        if self.token and not (tls or local):
            raise UsageError(
                f"a token is not sent to {address} without encryption: whoever is on the way could read it. "
                "Leave --no-tls out"
            )
        return tls and not address.startswith("unix:")


class _Details(NamedTuple):
    """A call's details, with more metadata; gRPC asks for these fields."""

    method: str
    timeout: float | None
    metadata: Any
    credentials: grpc.CallCredentials | None
    wait_for_ready: bool | None
    compression: grpc.Compression | None


class _Bearer(grpc.UnaryUnaryClientInterceptor, grpc.StreamStreamClientInterceptor):
    """Sends the token with every call. gRPC's own way does not do that on a connection without TLS, as on a socket."""

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
    """A channel to a server, on which every call shows the token.

    Raises:
        UsageError: if the token would be readable on its way.
    """
    if access.encrypts(address):
        name = (("grpc.ssl_target_name_override", access.name),) if access.name else ()
        credentials = grpc.ssl_channel_credentials(access.authority)
        channel = grpc.secure_channel(address, credentials, options=(*options, *name))
    else:
        channel = grpc.insecure_channel(address, options=options)
    return grpc.intercept_channel(channel, _Bearer(access.token)) if access.token else channel


def add_access(parser: argparse.ArgumentParser) -> None:
    """Adds the options that `access_of` reads."""
    add = parser.add_argument_group("access to a server of others").add_argument
    add("--token-file", type=Path, metavar="FILE", help=f"file with your token (default: ${VARIABLE}, if it is set)")
    add("--token", metavar="TOKEN", help="your token itself; rather use one of the two: others can see arguments")
    add("--tls", action=argparse.BooleanOptionalAction, help="encrypt (default: where a token leaves this machine)")
    add("--tls-ca", type=Path, metavar="FILE", help="trust these PEM certificates, not those of public authorities")


def access_of(options: argparse.Namespace) -> Access:
    """What the options, and the environment, say.

    Raises:
        UsageError: if a file cannot be read, or what there is cannot be a token.
    """
    token, origin = os.environ.get(VARIABLE, ""), f"${VARIABLE}"
    if options.token is not None:
        token, origin = options.token, "--token"
    elif options.token_file is not None:
        token, origin = _content(options.token_file).decode("utf-8", "replace"), str(options.token_file)
    token = token.strip()
    if not (token.isascii() and token.isprintable() and " " not in token) or (not token and origin != f"${VARIABLE}"):
        raise UsageError(f"what is in {origin} is no token, which is one word of letters, digits, - and _")
    authority = _content(options.tls_ca) if options.tls_ca is not None else None
    if authority is not None and options.tls is False:
        raise UsageError("--tls-ca is for TLS, which --no-tls leaves out")
    return Access(token=token, tls=options.tls, authority=authority)


def is_local(address: str) -> bool:
    """Whether the server is on this machine: on a Unix socket, or at a loopback address."""
    if address.startswith("unix:"):
        return True
    host = host_of(address)
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def host_of(address: str) -> str:
    """The host in an address, without the brackets of IPv6."""
    return address.removeprefix("dns:").lstrip("/").rpartition(":")[0].strip("[]")


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from error

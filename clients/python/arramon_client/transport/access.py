"""Credentials for a server: the participant's token, encryption, and their command-line options."""

import argparse
import codecs
import ipaddress
import os
from dataclasses import dataclass, field
from pathlib import Path

from arramon_client.errors import UsageError

VARIABLE = "ARRAMON_TOKEN"
"""Name of the environment variable with the token."""


@dataclass(frozen=True, slots=True)
class Access:
    """Credentials and encryption of a connection.

    Attributes:
        token: the participant's token; empty for none.
        tls: whether to encrypt the connection; None: only with `authority`, or to send a token to another machine.
        authority: PEM certificates to trust instead of those of public authorities; None for the latter.
        name: the server's name in its certificate, if it differs from the address; otherwise empty.
    """

    token: str = field(default="", repr=False)
    tls: bool | None = None
    authority: bytes | None = None
    name: str = ""

    def encrypts(self, address: str) -> bool:
        """Return whether a connection to an address is encrypted.

        Raises:
            UsageError: if a token would be sent to another machine without encryption.
        """
        local = is_local(address)
        tls = self.tls
        if tls is None:
            tls = self.authority is not None or bool(self.token and not local)
        if self.token and not (tls or local):
            raise UsageError(
                f"a token is not sent to {address} without encryption, as it could be read in transit: omit --no-tls"
            )
        return tls and not address.startswith("unix:")


def add_access(parser: argparse.ArgumentParser) -> None:
    """Add the options that `access_of` reads."""
    add = parser.add_argument_group("access to a remote server").add_argument
    add("--token-file", type=Path, metavar="FILE", help=f"file with your token (default: ${VARIABLE}, if set)")
    add("--token", metavar="TOKEN", help=f"your token; prefer --token-file or ${VARIABLE}: others can see arguments")
    add("--tls", action=argparse.BooleanOptionalAction, help="use TLS (default: if a token leaves this machine)")
    add("--tls-ca", type=Path, metavar="FILE", help="trust these PEM certificates instead of public authorities")


def access_of(options: argparse.Namespace) -> Access:
    """Return the access that the options and the environment specify; errors as for `make_access`."""
    return make_access(options.token, options.token_file, tls=options.tls, tls_ca=options.tls_ca)


def make_access(
    token: str | None = None, token_file: Path | None = None, *, tls: bool | None = None, tls_ca: Path | None = None
) -> Access:
    """Return an access.

    Args:
        token: the participant's token; None to read it from the file or, without one, from the environment.
        token_file: file with the token.
        tls: whether to encrypt the connection; None as in `Access`.
        tls_ca: file of PEM certificates to trust.

    Raises:
        UsageError: if a file cannot be read, or a token or certificate is malformed.
    """
    origin = "--token"
    if token is None and token_file is not None:
        token, origin = _text(token_file), str(token_file)
    elif token is None:
        token, origin = os.environ.get(VARIABLE, ""), f"${VARIABLE}"
    token = token.lstrip("\ufeff").strip()
    if not (token.isascii() and token.isprintable() and " " not in token) or (not token and origin != f"${VARIABLE}"):
        raise UsageError(f"{origin} does not contain a token: expected one word of letters, digits, - and _")
    authority = _authority(tls_ca) if tls_ca is not None else None
    if authority is not None and tls is False:
        raise UsageError("--tls-ca cannot be used together with --no-tls")
    return Access(token=token, tls=tls, authority=authority)


def is_local(address: str) -> bool:
    """Return whether an address is on this machine: a Unix socket, or a loopback address."""
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
    """Return the host part of an address, without the brackets of IPv6."""
    return address.removeprefix("dns:").lstrip("/").rpartition(":")[0].strip("[]")


def _authority(path: Path) -> bytes:
    """Return the content of a file with PEM certificates."""
    # Imported here, as an environment in this process needs neither certificates nor gRPC.
    from cryptography.x509 import load_pem_x509_certificates

    content = _content(path)
    try:
        load_pem_x509_certificates(content)
    except ValueError as error:
        raise UsageError(
            f"--tls-ca {path} contains no certificate: expected PEM, with a line -----BEGIN CERTIFICATE-----"
        ) from error
    return content


def _text(path: Path) -> str:
    """Return the text of a file, without a byte order mark if it has one."""
    content = _content(path)
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise UsageError(f"{path} is text in UTF-16, expected UTF-8: save it again as UTF-8")
    return content.decode("utf-8-sig", "replace")


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from error

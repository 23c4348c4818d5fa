"""The server's TLS certificate: read and checked at startup, and again whenever its files change."""

import logging
import ssl
from pathlib import Path
from typing import Any

import grpc

from arramon_server.configuration.config import Config
from arramon_server.errors import BadFile, BadInput

_log = logging.getLogger(__name__)


def grpc_credentials(config: Config) -> grpc.ServerCredentials | None:
    """Return the credentials of the gRPC server; None if no certificate is set.

    When the files change, new connections use the new certificate.

    Raises:
        BadInput: if a file cannot be read or has the wrong content, or the key is not the certificate's.
    """
    if config.tls_certificate is None or config.tls_key is None:
        return None
    files = _CertificateFiles(config.tls_certificate, config.tls_key)
    fetch: Any = files.fetch  # gRPC's type stub lacks None, which means no change
    return grpc.dynamic_ssl_server_credentials(files.read(), fetch, require_client_authentication=False)


def http_tls_context(config: Config) -> ssl.SSLContext | None:
    """Return the TLS context of the HTTP server, like `grpc_credentials`."""
    certificate, key = config.tls_certificate, config.tls_key
    if certificate is None or key is None:
        return None
    files = _CertificateFiles(certificate, key)
    files.read()
    first = latest = _context(certificate, key)

    def choose(connection: ssl.SSLObject, _name: str | None, _context_then: ssl.SSLContext) -> None:
        nonlocal latest
        if files.fetch() is not None:
            latest = _context(certificate, key)
        connection.context = latest

    first.sni_callback = choose
    return first


def _context(certificate: Path, key: Path) -> ssl.SSLContext:
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.load_cert_chain(certificate, key)
    return context


class _CertificateFiles:
    """The files of a certificate and its key."""

    def __init__(self, certificate: Path, key: Path) -> None:
        self._certificate, self._key = certificate, key
        self._stamps: tuple[int, ...] = ()

    def read(self) -> grpc.ServerCertificateConfiguration:
        """Read and check the files.

        Raises:
            BadInput: as `grpc_credentials`.
        """
        self._stamps = self._stamp()
        _check(self._certificate, self._key)
        pair = (_content(self._key), _content(self._certificate))
        return grpc.ssl_server_certificate_configuration([pair])

    def fetch(self) -> grpc.ServerCertificateConfiguration | None:
        """Return the new certificate; None if the files have not changed. gRPC calls this before every handshake."""
        if self._stamp() == self._stamps:
            return None
        try:
            fresh = self.read()
        except BadInput as error:  # for example while only one of the two files has been replaced
            _log.error("the certificate could not be renewed; the previous one stays in use: %s", error)
            return None
        _log.info("the certificate was renewed")
        return fresh

    def _stamp(self) -> tuple[int, ...]:
        try:
            return self._certificate.stat().st_mtime_ns, self._key.stat().st_mtime_ns
        except OSError:  # `read` reports the error
            return ()


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise BadFile(path, f"cannot be read: {error.strerror}") from error


def _check(certificate: Path, key: Path) -> None:
    for path in (certificate, key):
        _content(path)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(certificate, key, password="")
    except ssl.SSLError as error:
        if error.reason == "KEY_VALUES_MISMATCH":
            raise BadFile(key, f"is not the key of the certificate {certificate}") from error
        raise BadInput(
            f"{certificate} and {key} are not a certificate and its key in PEM format without a password: "
            f"{error.reason or error}"
        ) from error

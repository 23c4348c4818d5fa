"""Health check of a server, for `arramon-server health`, which containers and orchestrators use as a probe."""

from pathlib import Path

import grpc
from cryptography import x509
from grpc_health.v1 import health_pb2, health_pb2_grpc

from arramon_server.errors import BadFile, Unavailable

TIMEOUT = 5.0
"""Seconds to wait for an answer."""


def check(address: str, certificate: Path | None = None) -> None:
    """Check that the server at an address is ready for calls.

    Args:
        address: host:port or unix:/path.
        certificate: PEM file of the server's certificate, if it uses TLS. Only a server with the certificate's key is
            trusted, so the name in the certificate need not match the address.

    Raises:
        BadInput: if the certificate cannot be read.
        Unavailable: if the server cannot be reached, or reports that it does not serve, for instance while it drains.
    """
    with _channel(address, certificate) as channel:
        try:
            answer = health_pb2_grpc.HealthStub(channel).Check(health_pb2.HealthCheckRequest(), timeout=TIMEOUT)
        except grpc.RpcError as error:
            raise Unavailable(f"no answer from {address}: {error.code().name}") from error
    status = health_pb2.HealthCheckResponse.ServingStatus.Name(answer.status)
    if answer.status != health_pb2.HealthCheckResponse.SERVING:
        raise Unavailable(f"the server at {address} reports {status}, expected SERVING")


def _channel(address: str, certificate: Path | None) -> grpc.Channel:
    if certificate is None or address.startswith("unix:"):
        return grpc.insecure_channel(address)
    try:
        pem = certificate.read_bytes()
        own = x509.load_pem_x509_certificates(pem)[0]
        names = own.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except OSError as error:
        raise BadFile(certificate, f"cannot be read: {error.strerror}") from error
    except (ValueError, x509.ExtensionNotFound) as error:
        raise BadFile(certificate, f"is not a PEM certificate with a subject alternative name: {error}") from error
    name = str(next(iter(names)).value).replace("*", "any")
    options = (("grpc.ssl_target_name_override", name),)
    return grpc.secure_channel(address, grpc.ssl_channel_credentials(pem), options)

"""Asks a server whether it serves: what `arramon-server health` does, for a container's or an orchestrator's probe."""

import grpc
from grpc_health.v1 import health_pb2, health_pb2_grpc

from server.errors import Unavailable

TIMEOUT = 5.0
"""Seconds to wait for the answer."""


def check(address: str) -> None:
    """Returns if the server at `address` (host:port or unix:/path) is ready for calls.

    Raises:
        Unavailable: if it cannot be reached, or says that it does not serve, as while it drains.
    """
    with grpc.insecure_channel(address) as channel:
        try:
            answer = health_pb2_grpc.HealthStub(channel).Check(health_pb2.HealthCheckRequest(), timeout=TIMEOUT)
        except grpc.RpcError as error:
            raise Unavailable(f"no answer from {address}: {error.code().name}") from error
    status = health_pb2.HealthCheckResponse.ServingStatus.Name(answer.status)
    if answer.status != health_pb2.HealthCheckResponse.SERVING:
        raise Unavailable(f"the server at {address} says {status}")

"""Table of gRPC statuses by error class."""

import grpc

from arramon_server.errors import (
    ArraMonError,
    BadInput,
    Conflict,
    Forbidden,
    NotFound,
    OverQuota,
    TakenOver,
    Unauthenticated,
    Unavailable,
)

_TABLE = (
    (BadInput, grpc.StatusCode.INVALID_ARGUMENT),
    (NotFound, grpc.StatusCode.NOT_FOUND),
    (TakenOver, grpc.StatusCode.ABORTED),
    (Conflict, grpc.StatusCode.FAILED_PRECONDITION),
    (Unauthenticated, grpc.StatusCode.UNAUTHENTICATED),
    (Forbidden, grpc.StatusCode.PERMISSION_DENIED),
    (OverQuota, grpc.StatusCode.RESOURCE_EXHAUSTED),
    (Unavailable, grpc.StatusCode.UNAVAILABLE),
)


def status_of(error: ArraMonError) -> grpc.StatusCode:
    """Return the gRPC status of an error; INTERNAL if its class is not in the table."""
    for kind, code in _TABLE:
        if isinstance(error, kind):
            return code
    return grpc.StatusCode.INTERNAL

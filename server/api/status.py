"""The one table from an error to a gRPC status."""

import grpc

from server.errors import (
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
    """The status under which an error reaches the client; its message goes along as it is."""
    for kind, code in _TABLE:
        if isinstance(error, kind):
            return code
    return grpc.StatusCode.INTERNAL

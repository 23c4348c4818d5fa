"""Memory shared by a server on this machine, through which images are passed instead of through the socket."""

import mmap
import os
import stat
from contextlib import suppress

from arramon.v1 import types_pb2


class NotSharedError(Exception):
    """The shared memory cannot be opened, or is not the server's, for example because it is in another container."""


def shared_memory(message: types_pb2.SharedMemory) -> memoryview:
    """Map the memory shared by a server, read-only.

    Args:
        message: the server's description. It can only refer to a file that a process has open, not to other paths.

    Returns:
        (message.size,) bytes, which change as the server writes; an image stays until its observation is answered.

    Raises:
        NotSharedError: if it cannot be opened, or does not match the description.
    """
    path = f"/proc/{message.process:d}/fd/{message.descriptor:d}"
    try:
        file = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
        try:
            found = os.fstat(file)
            if not stat.S_ISREG(found.st_mode) or found.st_size != message.size or not message.token:
                raise NotSharedError(f"{path} is not the memory that the server shares")
            content = memoryview(mmap.mmap(file, message.size, access=mmap.ACCESS_READ))
        finally:
            with suppress(OSError):
                os.close(file)
    except (OSError, ValueError) as error:
        raise NotSharedError(f"{path} cannot be read: {error}") from error
    if content[: len(message.token)] != message.token:
        raise NotSharedError(f"{path} is not the memory that the server shares")
    return content

"""Memory that a server on this machine shares, for images that then need not go through the socket."""

import mmap
import os
import stat
from contextlib import suppress

from arramon.v1 import types_pb2


class NotSharedError(Exception):
    """The memory is not here, or not what the server said: it is in another container, say."""


def shared_memory(message: types_pb2.SharedMemory) -> memoryview:
    """The memory that a server shares, to be read only.

    Args:
        message: as the server sent it. Nothing in it can lead to any file but a process's own open one.

    Returns:
        (message.size,) bytes. They change as the server writes; what was shown stays until it is answered.

    Raises:
        NotSharedError: if it cannot be opened, or is not what the server said.
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

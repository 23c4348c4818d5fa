"""Images in memory shared with a server on this machine, which avoids sending them through the socket."""

import mmap
import os
import stat
from contextlib import suppress

from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2 import Opened
from arramon_client.errors import ProtocolError
from arramon_client.transport.images import ImageDecoder, ImagesUnreadableError

_FAILED = "shared memory is not available"


def decoder_of(opened: Opened) -> ImageDecoder:
    """Return the decoder of a stream's images, from the server's first message.

    Raises:
        ImagesUnreadableError: if the images are in shared memory that cannot be opened, or is not the server's, for
            example because it is in another container.
    """
    if opened.encoding != types_pb2.ENCODING_SHARED:
        return ImageDecoder()
    memory = map_memory(opened.shared)

    def read(image: types_pb2.Image, expected: int) -> memoryview:
        end = image.place + expected
        if end > len(memory):
            raise ProtocolError(
                f"an image of {expected} bytes at {image.place} is outside the shared memory of {len(memory)}"
            )
        return memory[image.place : end]

    return ImageDecoder({types_pb2.ENCODING_SHARED: read})


def map_memory(message: types_pb2.SharedMemory) -> memoryview:
    """Map the memory shared by a server, read-only.

    Args:
        message: the server's description. It can only refer to a file that a process has open, not to other paths.

    Returns:
        (message.size,) bytes, which change as the server writes; an image stays until its observation is answered.

    Raises:
        ImagesUnreadableError: if it cannot be opened, or does not match the description.
    """
    path = f"/proc/{message.process:d}/fd/{message.descriptor:d}"
    try:
        file = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
        try:
            found = os.fstat(file)
            # The server's memory file has no name in any folder, unlike other files that a process has open.
            is_memory = stat.S_ISREG(found.st_mode) and found.st_nlink == 0
            if not is_memory or found.st_size != message.size or not message.token:
                raise ImagesUnreadableError(f"{_FAILED}: {path} is not the memory that the server shares")
            content = memoryview(mmap.mmap(file, message.size, access=mmap.ACCESS_READ))
        finally:
            with suppress(OSError):
                os.close(file)
    except (OSError, ValueError) as error:
        raise ImagesUnreadableError(f"{_FAILED}: {path} cannot be read: {error}") from error
    if content[: len(message.token)] != message.token:
        raise ImagesUnreadableError(f"{_FAILED}: {path} is not the memory that the server shares")
    return content

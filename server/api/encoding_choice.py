"""Selection of a stream's image encoder from the encodings that the server offers."""

import sys
from collections.abc import Iterable

from arramon.v1.types_pb2 import ENCODING_SHARED, Encoding
from arramon_server.api.encoding import STANDARD_ENCODINGS, ImageEncoder, MessageEncoder, check_quality
from arramon_server.api.shared_memory import SharedMemoryEncoder
from arramon_server.errors import BadInput


def offered_encodings(listen: str) -> tuple[Encoding.ValueType, ...]:
    """Return the encodings offered at an address. Shared memory is offered only on Unix sockets, so on one machine."""
    local = listen.startswith("unix:") and sys.platform == "linux"
    return (*STANDARD_ENCODINGS, ENCODING_SHARED) if local else STANDARD_ENCODINGS


def choose_encoder(
    encoding: Encoding.ValueType,
    jpeg_quality: int,
    offered: tuple[Encoding.ValueType, ...],
    *,
    episodes: int,
    sensors: Iterable[str],
    size: int,
) -> ImageEncoder:
    """Return the image encoder for a stream.

    Args:
        encoding: requested encoding; ENCODING_UNSPECIFIED for the first one offered.
        jpeg_quality: 1 to 100 if JPEG is requested, or 0 for the default.
        offered: encodings that a client may choose.
        episodes: maximum number of open episodes.
        sensors: sensors of the run.
        size: side length of the images, in pixels.

    Raises:
        BadInput: if the encoding is not offered, or the quality is out of range or given for another encoding.
    """
    encoding = encoding or offered[0]
    if encoding not in offered:
        raise BadInput(f"encoding {encoding} is not offered; see ServerInfo.encodings")
    if encoding == ENCODING_SHARED:
        check_quality(encoding, jpeg_quality)
        return SharedMemoryEncoder(episodes, sensors, size)
    return MessageEncoder(encoding, jpeg_quality)

"""Images that travel in memory shared with a client on this machine (Linux): nothing large goes through the socket.

The memory has no name in any folder: it is this process's alone to hand out, gone with its last user however that ends,
and only the same user's processes can open it. The server never reads from it, and it cannot be made smaller.
"""

import fcntl
import mmap
import os
import secrets
import sys
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from arramon.v1.types_pb2 import ENCODING_SHARED, Encoding, Image, SharedMemory
from server.api.encoding import OFFERED

IMAGES = {"rgb": 3, "depth": 2, "segmentation": 2}
"""Bytes a pixel of what each sensor shows."""

_TOKEN = 16
_HEADER = 64
"""Bytes before the first image: the token, and room so that images lie at whole cache lines."""


def offered(listen: str) -> tuple[Encoding.ValueType, ...]:
    """The encodings that a server offers at an address: sharing is for a Unix socket, so for one machine."""
    return (*OFFERED, ENCODING_SHARED) if listen.startswith("unix:") and sys.platform == "linux" else OFFERED


class Shared:
    """Memory for the images of one stream: of each open episode those of its latest observation.

    Args:
        episodes: that may be open at once.
        sensors: of the run.
        size: side length of the images, in pixels.
    """

    def __init__(self, episodes: int, sensors: Iterable[str], size: int) -> None:
        self._each = _aligned(size * size * sum(IMAGES.get(sensor, 0) for sensor in sensors))
        length = _HEADER + episodes * self._each
        self._file = os.memfd_create("arramon-images", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        os.fchmod(self._file, 0o600)
        os.ftruncate(self._file, length)
        fcntl.fcntl(self._file, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL)
        self._bytes = np.frombuffer(mmap.mmap(self._file, length), np.uint8)
        token = secrets.token_bytes(_TOKEN)
        self._bytes[:_TOKEN] = np.frombuffer(token, np.uint8)
        self.message = SharedMemory(process=os.getpid(), descriptor=self._file, size=length, token=token)
        self._free = list(range(length - self._each, 0, -self._each)) if self._each else []
        self._places: dict[str, int] = {}

    def close(self) -> None:
        """Closes the file. The memory goes when nobody looks at it any more: this object, and the client."""
        os.close(self._file)

    def has_room(self, episode_id: str) -> bool:
        """Whether the images of an episode find room."""
        return episode_id in self._places or bool(self._free)

    def write(
        self, episode_id: str, images: Iterable[tuple[npt.NDArray[np.uint8] | npt.NDArray[np.uint16], Image]]
    ) -> None:
        """Puts an observation's images where those of the episode's last one were, and says so in empty messages.

        Args:
            episode_id: of an open episode that `has_room`.
            images: (height, width, 3) uint8 or (height, width) uint16, and the message of each.
        """
        if episode_id not in self._places:
            self._places[episode_id] = self._free.pop()
        place = self._places[episode_id]
        for pixels, image in images:
            flat = (
                pixels.astype("<u2" if pixels.dtype == np.uint16 else np.uint8, copy=False).reshape(-1).view(np.uint8)
            )
            self._bytes[place : place + flat.size] = flat
            image.height, image.width = pixels.shape[:2]
            image.encoding, image.place = ENCODING_SHARED, place
            place += flat.size

    def forget(self, episode_id: str) -> None:
        """The episode is open no more: another one can have its room."""
        place = self._places.pop(episode_id, None)
        if place is not None:
            self._free.append(place)


def _aligned(length: int) -> int:
    return -(-length // _HEADER) * _HEADER

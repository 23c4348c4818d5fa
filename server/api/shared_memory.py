"""Images in memory shared with a client on the same machine (Linux), so that no pixels go through the socket.

The memory is anonymous (`memfd_create`): it has no path, it is freed when its last user ends in any way, and only
processes of the same user can open it. The server never reads from it, and its size is sealed.
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
from server.api.encoding import STANDARD_ENCODINGS

IMAGES = {"rgb": 3, "depth": 2, "segmentation": 2}
"""Bytes per pixel, by sensor."""

_TOKEN = 16
_HEADER = 64
"""Bytes before the first image: the token, and padding that aligns images to cache lines."""


def offered_encodings(listen: str) -> tuple[Encoding.ValueType, ...]:
    """Return the encodings offered at an address: shared memory only on a Unix socket, so on one machine."""
    return (
        (*STANDARD_ENCODINGS, ENCODING_SHARED)
        if listen.startswith("unix:") and sys.platform == "linux"
        else STANDARD_ENCODINGS
    )


class SharedImages:
    """Shared memory of one stream: the images of the latest observation of each open episode.

    Args:
        episodes: number that may be open at once.
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
        """Close the file. The memory is freed when neither this object nor the client maps it any more."""
        os.close(self._file)

    def has_room(self, episode_id: str) -> bool:
        """Return whether there is room for the images of an episode."""
        return episode_id in self._places or bool(self._free)

    def write(
        self, episode_id: str, images: Iterable[tuple[npt.NDArray[np.uint8] | npt.NDArray[np.uint16], Image]]
    ) -> None:
        """Write an observation's images over those of the episode's last one, and their place into empty messages.

        Args:
            episode_id: of an open episode for which `has_room` is true.
            images: pairs of pixels, (height, width, 3) uint8 or (height, width) uint16, and their empty message.
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
        """Free the room of an episode that has ended."""
        place = self._places.pop(episode_id, None)
        if place is not None:
            self._free.append(place)


def _aligned(length: int) -> int:
    return -(-length // _HEADER) * _HEADER

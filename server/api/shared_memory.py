"""Images in memory shared with a client on the same machine (Linux), so that no pixels pass through the socket.

The memory is anonymous (`memfd_create`): it has no path, it is freed when the last process that uses it ends, in
whatever way, and only processes of the same user can open it. The server never reads from it, and its size is sealed.
"""

import fcntl
import mmap
import os
import secrets
import threading
from collections.abc import Iterable
from typing import Self

import numpy as np
import numpy.typing as npt

from arramon.v1.evaluation_pb2 import Opened
from arramon.v1.types_pb2 import ENCODING_RAW, ENCODING_SHARED, SharedMemory
from arramon_server.api.encoding import Images, MessageEncoder, little_endian
from arramon_server.api.wire import Data
from arramon_server.sim.cameras import Frame

IMAGE_SENSORS = {"rgb": 3, "depth": 2, "segmentation": 2}
"""Bytes per pixel of each sensor's images."""

_TOKEN = 16
_HEADER = 64
"""Bytes before the first image: the token, and padding that aligns images to cache lines."""


class SharedMemoryEncoder:
    """Writes the images of each open episode's latest observation to shared memory, and all others raw into messages.

    The memory exists while the encoder is used as a context manager.

    Args:
        episodes: maximum number of open episodes.
        sensors: sensors of the run.
        size: side length of the images, in pixels.
    """

    encoding = ENCODING_SHARED
    jpeg_quality = 0
    image_quality = "lossless"
    compresses = False

    def __init__(self, episodes: int, sensors: Iterable[str], size: int) -> None:
        self._episodes = episodes
        given = set(sensors)
        self._sensors = tuple(sensor for sensor in IMAGE_SENSORS if sensor in given)
        self._size = size
        self._each = size * size * sum(IMAGE_SENSORS[sensor] for sensor in self._sensors)
        self._drawing = threading.Lock()
        self._canvases: dict[str, Frame] = {}
        self._in_messages = MessageEncoder(ENCODING_RAW)
        self._memory: SharedImages | None = None

    def __enter__(self) -> Self:
        """Allocate the memory."""
        self._memory = SharedImages(self._episodes, self._each)
        return self

    def __exit__(self, *error: object) -> None:
        """Close the memory. It is freed once the client no longer maps it."""
        if self._memory is not None:
            self._memory.close()
            self._memory = None
            self._canvases.clear()

    def announce(self, opened: Opened) -> None:
        """Add the location of the memory to a stream's first message."""
        opened.encoding = self.encoding
        if self._memory is not None:
            opened.shared.CopyFrom(self._memory.message)

    def canvas(self, episode_id: str) -> Frame | None:
        """Return an episode's RGB and depth buffers in shared memory; None if no slot is free, or alignment forbids it.

        Any thread that draws may call this.
        """
        if self._memory is None or self._size % 2 or self._sensors[:2] != ("rgb", "depth"):
            return None
        with self._drawing:
            if episode_id not in self._canvases:
                slot = self._memory.slot(episode_id)
                if slot is None:
                    return None
                pixels = self._size * self._size
                rgb = slot[: 3 * pixels].reshape(self._size, self._size, 3)
                depth = slot[3 * pixels : 5 * pixels].view(np.uint16).reshape(self._size, self._size)
                self._canvases[episode_id] = Frame(rgb, depth)
            return self._canvases[episode_id]

    def encode(self, episode_id: str, images: Images, *, latest: bool) -> list[Data]:
        """Encode the images of one observation; the latest one overwrites the episode's previous images."""
        images = list(images)
        if latest and self._memory is not None and self._memory.write(episode_id, images):
            return [b""] * len(images)
        return self._in_messages.encode(episode_id, images, latest=latest)

    def forget(self, episode_id: str) -> None:
        """Free the slot of an episode that has ended."""
        self._canvases.pop(episode_id, None)
        if self._memory is not None:
            self._memory.forget(episode_id)


class SharedImages:
    """Shared memory with a slot for the images of one observation of each open episode.

    Args:
        episodes: maximum number of open episodes.
        each: size of one observation's images, in bytes.
    """

    def __init__(self, episodes: int, each: int) -> None:
        self._each = -(-each // _HEADER) * _HEADER
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
        """Close the file. The memory is freed once neither this object nor the client maps it."""
        os.close(self._file)

    def slot(self, episode_id: str) -> npt.NDArray[np.uint8] | None:
        """Return the slot for an episode's images, aligned to cache lines; None if no slot is free."""
        if episode_id not in self._places:
            if not self._free:
                return None
            self._places[episode_id] = self._free.pop()
        place = self._places[episode_id]
        return self._bytes[place : place + self._each]

    def write(self, episode_id: str, images: Images) -> bool:
        """Overwrite the episode's previous images with an observation's, and write their positions into empty messages.

        Returns:
            False, without having written anything, if no slot is free.
        """
        slot = self.slot(episode_id)
        if slot is None:
            return False
        place = first = self._places[episode_id]
        for pixels, image in images:
            flat = little_endian(pixels).reshape(-1).view(np.uint8)
            here = slot[place - first : place - first + flat.size]
            if not np.may_share_memory(here, flat):  # Images that were drawn here need not be copied.
                here[:] = flat
            image.height, image.width = pixels.shape[:2]
            image.encoding, image.place = ENCODING_SHARED, place
            place += flat.size
        return True

    def forget(self, episode_id: str) -> None:
        """Free the slot of an episode that has ended."""
        place = self._places.pop(episode_id, None)
        if place is not None:
            self._free.append(place)

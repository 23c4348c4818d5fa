"""Drawing of requested frames: a few at once, at a low priority, and none for clients that have left."""

import asyncio
import os
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import ThreadPoolExecutor

from arramon_server.errors import Unavailable

THREADS = 2
"""Frames that are drawn at once."""

MAX_WAITING = 64
"""Requests that wait for a thread; further ones are refused."""

CACHED_FRAMES = 256
"""Number of cached frames, about 50 KB each."""

NICENESS = 10
"""Niceness of the drawing threads: play goes first."""


class ClientLeft(Exception):
    """The client that asked for a frame has closed its connection."""


class FrameQueue:
    """Draws and caches frames. Use it on one event loop.

    Args:
        threads: number of frames drawn at once.
    """

    def __init__(self, threads: int = THREADS) -> None:
        self._pool = ThreadPoolExecutor(threads, "frames", initializer=_lower_priority)
        self._slots = asyncio.Semaphore(threads)
        self._waiting = 0
        self._kept = OrderedDict[Hashable, bytes]()

    async def frame(self, key: Hashable, draw: Callable[[], bytes], has_left: Callable[[], bool]) -> bytes:
        """Return a frame from the cache, or draw it.

        Args:
            key: identity of the frame.
            draw: draws and encodes it; called in a thread.
            has_left: whether the client has left: then nothing is drawn.

        Raises:
            Unavailable: if too many requests are waiting.
            ClientLeft: if the client left while it waited.
        """
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        if self._waiting >= MAX_WAITING:
            raise Unavailable("too many frames are asked for at once; try again in a moment")
        self._waiting += 1
        try:
            async with self._slots:
                if has_left():
                    raise ClientLeft
                frame = await asyncio.get_running_loop().run_in_executor(self._pool, draw)
        finally:
            self._waiting -= 1
        self._kept[key] = frame
        if len(self._kept) > CACHED_FRAMES:
            self._kept.popitem(last=False)
        return frame

    def close(self) -> None:
        """Draw no more frames, and end the threads."""
        self._pool.shutdown(wait=True, cancel_futures=True)


def _lower_priority() -> None:
    """Let play go before this thread, where the system can set the priority of a single thread."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)

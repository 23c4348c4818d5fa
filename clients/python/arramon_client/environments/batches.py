"""Memory of batched observations: blocks, shared between processes if there are several, that are leased to a learner.

Memory that is used again is in the processor's caches; fresh memory costs a page fault for every 4 kB. In this process
it lies in large pages where the system has them: writing a frame then takes 7% less, as fewer addresses are looked up.
"""

import ctypes
import weakref
from multiprocessing.context import BaseContext
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

Arrays = dict[str, npt.NDArray[Any]]
"""A batch: by name an array of (episodes, ...). Texts are not part of it."""

BLOCKS = 4
"""Batches that may be in use at once without being copied: what is written, and what a learner still holds."""

ALIGNMENT = 64
"""Arrays in a block begin at multiples of this, in bytes."""

LARGE_PAGE = 1 << 21
"""Bytes of a large page."""


class Layout:
    """Shapes and types of a batch, and where each array lies in a block.

    Args:
        space: of a single observation.
        count: number of episodes.

    Attributes:
        size: bytes of a block.
    """

    def __init__(self, space: spaces.Dict, count: int) -> None:
        self._fields: dict[str, tuple[tuple[int, ...], np.dtype[Any], int]] = {}
        self.size = 0
        for name, part in batch_space(space, count).items():  # type: ignore[attr-defined]  # of a Dict, a Dict
            if isinstance(part, spaces.Box | spaces.MultiDiscrete):
                shape, kind = part.shape, np.dtype(part.dtype)
                self._fields[name] = (shape, kind, self.size)
                nbytes = int(np.prod(shape)) * kind.itemsize
                self.size += -(-nbytes // ALIGNMENT) * ALIGNMENT

    def over(self, block: Any) -> Arrays:
        """Return arrays over a block of memory, which lives as long as one of them does."""
        return {name: np.ndarray(shape, kind, block, offset) for name, (shape, kind, offset) in self._fields.items()}


class Leases:
    """Blocks of memory: each is handed out again when no array over it is left, the last one that became free first.

    Args:
        layout: of a batch.
        context: of the processes that share the blocks; None for memory of this process.
    """

    def __init__(self, layout: Layout, context: BaseContext | None) -> None:
        self._layout = layout
        count = range(BLOCKS + 1)
        if context is None:
            self.blocks: list[Any] = [_own_memory(layout.size) for _ in count]
        else:
            self.blocks = [context.RawArray(ctypes.c_ubyte, layout.size) for _ in count]
        self._free = list(range(BLOCKS))

    def take(self) -> tuple[int, Arrays | None]:
        """Return the number of a block, and arrays over it that may be handed to a learner.

        If a learner holds all of them, it is the last block, which is never handed out, and None.
        """
        if not self._free:
            return BLOCKS, None
        number = self._free.pop()
        # An object of its own, so that the end of all arrays over it is noticed: they hold it, not the block.
        lease = (ctypes.c_ubyte * self._layout.size).from_buffer(self.blocks[number])
        weakref.finalize(lease, self._free.append, number)
        return number, self._layout.over(lease)


def _own_memory(size: int) -> npt.NDArray[np.uint8]:
    """Return memory of this process, (size,) uint8, which begins with a large page if it is longer than one."""
    start = LARGE_PAGE if size > LARGE_PAGE else ALIGNMENT
    memory = np.empty(size + start, np.uint8)  # NumPy asks for large pages by itself, from 4 MB on.
    first = -memory.ctypes.data % start
    return memory[first : first + size]

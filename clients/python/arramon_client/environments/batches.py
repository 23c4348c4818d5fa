"""Memory of batched observations: blocks, shared between processes if there are several, that are leased to a learner.

Memory that is used again is in the processor's caches; fresh memory costs a page fault for every 4 kB. In this process
it lies in large pages where the system has them: writing a frame then takes 7% less, as fewer addresses are looked up.
"""

import ctypes
import weakref
from dataclasses import dataclass
from multiprocessing.context import BaseContext
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

Arrays = dict[str, npt.NDArray[Any]]
"""Observations of a batch: by name an array of (episodes, ...). Texts are not part of it."""

BLOCKS = 4
"""Batches that may be in use at once without being copied: what is written, and what a learner still holds."""

ALIGNMENT = 64
"""Arrays in a block begin at multiples of this, in bytes."""

LARGE_PAGE = 1 << 21
"""Bytes of a large page."""


@dataclass(frozen=True, slots=True, eq=False)
class VectorBatch:
    """What a step leads to, in one block of memory.

    Attributes:
        observation: by name an array of (episodes, ...).
        rewards: (episodes,) float64.
        terminated, truncated: (episodes,) bool.
    """

    observation: Arrays
    rewards: npt.NDArray[np.float64]
    terminated: npt.NDArray[np.bool_]
    truncated: npt.NDArray[np.bool_]

    def copy(self) -> "VectorBatch":
        """Return a copy in memory of its own."""
        values = {name: array.copy() for name, array in self.observation.items()}
        return VectorBatch(values, self.rewards.copy(), self.terminated.copy(), self.truncated.copy())


class BatchLayout:
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
                self._fields[name] = self._placed(part.shape, np.dtype(part.dtype))
        self._outcome = [self._placed((count,), np.dtype(kind)) for kind in (np.float64, np.bool_, np.bool_)]

    def _placed(self, shape: tuple[int, ...], kind: np.dtype[Any]) -> tuple[tuple[int, ...], np.dtype[Any], int]:
        start = self.size
        self.size += -(-int(np.prod(shape)) * kind.itemsize // ALIGNMENT) * ALIGNMENT
        return shape, kind, start

    def over(self, block: Any) -> VectorBatch:
        """Return arrays over a block of memory, which lives as long as one of them does."""
        values = {name: np.ndarray(shape, kind, block, offset) for name, (shape, kind, offset) in self._fields.items()}
        return VectorBatch(values, *(np.ndarray(shape, kind, block, offset) for shape, kind, offset in self._outcome))


class BlockPool:
    """Blocks of memory: each is handed out again when no array over it is left, the last one that became free first.

    Args:
        layout: of a batch.
        context: of the processes that share the blocks; None for memory of this process.
        count: number of blocks.

    Attributes:
        blocks: all of them.
    """

    def __init__(self, layout: BatchLayout, context: BaseContext | None, count: int) -> None:
        self._layout = layout
        if context is None:
            self.blocks: list[Any] = [_own_memory(layout.size) for _ in range(count)]
        else:
            self.blocks = [context.RawArray(ctypes.c_ubyte, layout.size) for _ in range(count)]
        self._free = list(range(count))
        self._leased: dict[int, weakref.ref[Any]] = {}

    @property
    def free_count(self) -> int:
        """Number of blocks that may be taken."""
        return len(self._free)

    def take(self) -> int:
        """Return the number of a block, which is free no more.

        Raises:
            IndexError: if none is free.
        """
        return self._free.pop()

    def release(self, number: int) -> None:
        """Make a block free that was taken and not handed out."""
        self._free.append(number)

    def lease(self, number: int) -> VectorBatch:
        """Return arrays over a block that was taken, for a learner: it is free again when none of them is left."""
        # An object of its own, so that the end of all arrays over it is noticed: they hold it, not the block.
        lease = (ctypes.c_ubyte * self._layout.size).from_buffer(self.blocks[number])
        free = self._free
        self._leased[number] = weakref.ref(lease, lambda _: free.append(number))
        return self._layout.over(lease)


def _own_memory(size: int) -> npt.NDArray[np.uint8]:
    """Return memory of this process, (size,) uint8, which begins with a large page if it is longer than one."""
    start = LARGE_PAGE if size > LARGE_PAGE else ALIGNMENT
    memory = np.empty(size + start, np.uint8)  # NumPy asks for large pages by itself, from 4 MB on.
    first = -memory.ctypes.data % start
    return memory[first : first + size]

"""Memory of batched observations: new arrays for one process, leased blocks of shared memory for several."""

import ctypes
import weakref
from collections import deque
from multiprocessing.context import BaseContext
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

Arrays = dict[str, npt.NDArray[Any]]
"""A batch: by name an array of (episodes, ...). Texts are not part of it."""

BLOCKS = 4
"""Batches of shared memory that may be in use at once: what is written, and what a learner still holds."""

ALIGNMENT = 64
"""Arrays in a block begin at multiples of this, in bytes."""


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

    def new(self) -> Arrays:
        """Return new arrays."""
        return {name: np.empty(shape, kind) for name, (shape, kind, _) in self._fields.items()}

    def over(self, block: Any) -> Arrays:
        """Return arrays over a block of memory, which lives as long as one of them does."""
        return {
            name: np.frombuffer(block, kind, int(np.prod(shape)), offset).reshape(shape)
            for name, (shape, kind, offset) in self._fields.items()
        }


class Leases:
    """Blocks of shared memory: each is handed out again when no array over it is left.

    Args:
        layout: of a batch.
        context: of the processes that share the blocks.
    """

    def __init__(self, layout: Layout, context: BaseContext) -> None:
        self._layout = layout
        self.blocks = [context.RawArray(ctypes.c_ubyte, layout.size) for _ in range(BLOCKS + 1)]
        self._free = deque(range(BLOCKS))

    def take(self) -> tuple[int, Arrays | None]:
        """Return the number of a block, and arrays over it that may be handed to a learner.

        If a learner holds all of them, it is the last block, which is never handed out, and None.
        """
        if not self._free:
            return BLOCKS, None
        number = self._free.popleft()
        # An object of its own, so that the end of all arrays over it is noticed: they hold it, not the block.
        lease = (ctypes.c_ubyte * self._layout.size).from_buffer(self.blocks[number])
        weakref.finalize(lease, self._free.append, number)
        return number, self._layout.over(lease)

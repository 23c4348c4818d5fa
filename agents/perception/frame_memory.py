"""What was found in the last frames: an agent that is stuck, or looks around, sees the same frame again."""

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Iterable
from typing import Generic, TypeVar

import numpy as np
import numpy.typing as npt

Found = TypeVar("Found")


class FrameCache(Generic[Found]):
    """Looks at each of the last frames once.

    Args:
        look: returns what it finds in each frame of a batch: RGB, (B, H, W, 3) uint8, and depth, (B, H, W) float32.
        frames: number of recent frames that are remembered.
    """

    def __init__(
        self, look: Callable[[npt.NDArray[np.uint8], npt.NDArray[np.float32]], Iterable[Found]], frames: int
    ) -> None:
        self._look, self._frames = look, frames
        self._known: OrderedDict[bytes, Found] = OrderedDict()

    def find(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> list[Found]:
        """Return what is found in each frame of a batch; it is shared between equal frames: do not change it."""
        marks = [_mark(*images) for images in zip(rgb, depth, strict=True)]
        new = {mark: number for number, mark in enumerate(marks) if mark not in self._known}
        if new:
            chosen = list(new.values())
            self._known.update(zip(new, self._look(rgb[chosen], depth[chosen]), strict=True))
        found = [self._known[mark] for mark in marks]
        for mark in marks:
            self._known.move_to_end(mark)
        while len(self._known) > self._frames:
            self._known.popitem(last=False)
        return found


def _mark(rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> bytes:
    """Return a digest of one frame."""
    digest = hashlib.sha256(np.ascontiguousarray(rgb).data)
    digest.update(np.ascontiguousarray(depth).data)
    return digest.digest()

"""Cache of perception results by frame: an agent that is stuck, or looks around, sees the same frame again."""

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Iterable, Sequence
from typing import Generic, TypeVar

import numpy as np
import numpy.typing as npt

Found = TypeVar("Found")


class FrameCache(Generic[Found]):
    """Least-recently-used cache of a function of frames.

    Args:
        look: computes the result of each frame of a batch: RGB, (B, H, W, 3) uint8, and depth, (B, H, W) float32.
        frames: maximum number of cached frames.
    """

    def __init__(
        self, look: Callable[[npt.NDArray[np.uint8], npt.NDArray[np.float32]], Iterable[Found]], frames: int
    ) -> None:
        self._look, self._frames = look, frames
        self._known: OrderedDict[bytes, Found] = OrderedDict()

    def find(
        self,
        rgb: Sequence[npt.NDArray[np.uint8]] | npt.NDArray[np.uint8],
        depth: Sequence[npt.NDArray[np.float32]] | npt.NDArray[np.float32],
    ) -> list[Found]:
        """Return the result of each frame. Equal frames share one result, which must not be changed.

        Args:
            rgb: frames, or a batch of them.
            depth: the same for depth.
        """
        marks = [_mark(*images) for images in zip(rgb, depth, strict=True)]
        new = {mark: number for number, mark in enumerate(marks) if mark not in self._known}
        if new:
            chosen = np.stack([rgb[number] for number in new.values()])
            found = self._look(chosen, np.stack([depth[number] for number in new.values()]))
            self._known.update(zip(new, found, strict=True))
        results = [self._known[mark] for mark in marks]
        for mark in marks:
            self._known.move_to_end(mark)
        while len(self._known) > self._frames:
            self._known.popitem(last=False)
        return results


def _mark(rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> bytes:
    """Return a digest of one frame."""
    digest = hashlib.sha256(np.ascontiguousarray(rgb).data)
    digest.update(np.ascontiguousarray(depth).data)
    return digest.digest()

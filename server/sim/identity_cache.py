"""A cache by identity, for arguments that are the same object from frame to frame and slow to hash."""

from collections.abc import Callable
from typing import Generic, TypeVar

K = TypeVar("K")
V = TypeVar("V")


class IdentityCache(Generic[K, V]):
    """A function that remembers its results by the identity of its first argument. For use from any thread.

    Args:
        make: the function.
        size: results that are kept; when there are more, all are forgotten.
    """

    def __init__(self, make: Callable[..., V], size: int) -> None:
        self._make, self._size = make, size
        self._kept: dict[tuple[int, ...], tuple[K, V]] = {}
        """With the argument itself, so that no other object gets its identity."""

    def __call__(self, key: K, *more: int) -> V:
        """Return the function's result for an object, and further numbers."""
        place = (id(key), *more)
        found = self._kept.get(place)
        if found is not None:
            return found[1]
        value = self._make(key, *more)
        if len(self._kept) >= self._size:
            self._kept.clear()
        self._kept[place] = (key, value)
        return value

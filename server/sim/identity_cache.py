"""Cache by object identity, for arguments that stay the same object from frame to frame and are slow to hash."""

from collections.abc import Callable
from typing import Generic, TypeVar

K = TypeVar("K")
V = TypeVar("V")


class IdentityCache(Generic[K, V]):
    """A function that caches its results by the identity of its first argument. Thread-safe.

    Args:
        make: the function.
        size: maximum number of cached results; when it is reached, all are dropped.
    """

    def __init__(self, make: Callable[..., V], size: int) -> None:
        self._make, self._size = make, size
        self._kept: dict[tuple[int, ...], tuple[K, V]] = {}
        """Includes the argument itself, so that no other object can get its identity."""

    def __call__(self, key: K, *more: int) -> V:
        """Return the function's result for an object and further numbers."""
        place = (id(key), *more)
        found = self._kept.get(place)
        if found is not None:
            return found[1]
        value = self._make(key, *more)
        if len(self._kept) >= self._size:
            self._kept.clear()
        self._kept[place] = (key, value)
        return value

"""A pool of numbers, each reserved for the lifetime of an object and then reused."""

import weakref
from functools import cache
from itertools import count


class NumberPool:
    """A pool of numbers from 0; each becomes free again when its holder is garbage-collected."""

    def __init__(self) -> None:
        self._free: list[int] = []
        self._next = count()

    def take(self, holder: object) -> int:
        """Reserve a number for the lifetime of `holder`, and return it."""
        number = self._free.pop() if self._free else next(self._next)
        weakref.finalize(holder, self._free.append, number)
        return number


@cache
def expert_numbers() -> NumberPool:
    """Return the pool of numbers that this process's experts share."""
    return NumberPool()

"""Numbers that objects hold as long as they live, and that are used again afterwards."""

import weakref
from functools import cache
from itertools import count


class Slots:
    """Numbers from 0, each free again when its holder is gone."""

    def __init__(self) -> None:
        self._free: list[int] = []
        self._next = count()

    def take(self, holder: object) -> int:
        """Return a number that nothing else holds as long as the holder lives."""
        slot = self._free.pop() if self._free else next(self._next)
        weakref.finalize(holder, self._free.append, slot)
        return slot


@cache
def expert_slots() -> Slots:
    """Return the slots of the experts of this process."""
    return Slots()

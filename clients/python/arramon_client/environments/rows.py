"""Rows of batches that several processes fill: whoever has an episode ready takes the next row.

Rows are handed out through a pipe, from which each process reads the number of one row at a time, and filled ones are
reported through another. So no process holds a lock that would remain locked after its death, and the pipes order what
is written to shared memory on every processor.
"""

import os
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

import gymnasium

from arramon_client.environments.batches import BatchLayout, VectorBatch
from arramon_client.environments.group import Call, EpisodeGroup, EpisodeUpdates
from arramon_client.errors import ArramonClientError

SLOT = struct.Struct("=i")
"""A row: number of its block times the rows of a block, and its number there."""

REPORT = struct.Struct("=iii")
"""The number of an episode, its row, and what follows in the pipe of its process."""

NOTHING, UPDATES, ERROR = 0, 1, 2
"""What follows a report: nothing, `EpisodeUpdates`, or an error that ends all rows."""


@dataclass(eq=False)
class RowWriter:
    """What a process needs to fill rows.

    Attributes:
        layout: of a block.
        blocks: shared memory.
        count: rows of a block.
        free: from which the numbers of rows are read.
        filled: to which reports are written.
    """

    layout: BatchLayout
    blocks: Sequence[Any]
    count: int
    free: "Connection[Any, Any]"
    filled: "Connection[Any, Any]"
    _batches: Sequence[VectorBatch] = ()

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_batches": ()}

    def draw(self, group: EpisodeGroup, number: int) -> tuple[int, EpisodeUpdates | None]:
        """Draw an episode to the next row, and return the row and what is new."""
        self._batches = self._batches or [self.layout.over(block) for block in self.blocks]
        (slot,) = SLOT.unpack(os.read(self.free.fileno(), SLOT.size))
        return slot, group.draw(number, self._batches[slot // self.count], slot % self.count)

    def fill(self, group: EpisodeGroup, calls: Sequence[tuple[int, Call]], pipe: "Connection[Any, Any]") -> None:
        """Play calls, each with the number of its episode, and report each row.

        Args:
            group: that plays them.
            calls: actions and beginnings.
            pipe: of this process, for what follows a report.
        """
        try:
            for number in group.apply(calls):
                slot, updates = self.draw(group, number)
                self._report(number, slot, NOTHING if updates is None else UPDATES)
                if updates is not None:
                    pipe.send(updates)
        except (gymnasium.error.Error, ArramonClientError) as error:
            self._report(calls[0][0], 0, ERROR)
            pipe.send(error)

    def _report(self, number: int, slot: int, follows: int) -> None:
        os.write(self.filled.fileno(), REPORT.pack(number, slot, follows))


def reports(data: bytes) -> Iterable[tuple[int, int, int]]:
    """Return the reports in what was read from the pipe: episode, row, and what follows."""
    return REPORT.iter_unpack(data)

"""Filling of a batch's rows by several processes: each takes the next free row when it has an episode ready.

The numbers of free rows are distributed through a pipe, from which each process reads one at a time, and filled rows
are reported through another pipe. Thus no process holds a lock that would stay locked if it died, and the pipes also
order the writes to shared memory on every processor.
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
"""Encoding of a row: its block's number times the rows per block, plus its number in the block."""

REPORT = struct.Struct("=iii")
"""Encoding of a report: episode number, row, and what the process sends next through its own pipe."""

NOTHING, UPDATES, ERROR = 0, 1, 2
"""What follows a report: nothing, `EpisodeUpdates`, or an error that ends the batch."""


@dataclass(eq=False)
class RowWriter:
    """Writer of rows, used by each process.

    Attributes:
        layout: layout of a block.
        blocks: blocks of shared memory, by number.
        count: number of rows of a block.
        free: pipe from which the numbers of free rows are read.
        filled: pipe to which reports are written.
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
        """Write an episode to the next free row; return the row, and the episode's updates or None."""
        self._batches = self._batches or [self.layout.over(block) for block in self.blocks]
        (slot,) = SLOT.unpack(os.read(self.free.fileno(), SLOT.size))
        return slot, group.draw(number, self._batches[slot // self.count], slot % self.count)

    def fill(self, group: EpisodeGroup, calls: Sequence[tuple[int, Call]], pipe: "Connection[Any, Any]") -> None:
        """Play calls, each with the number of its episode, and report each row.

        Args:
            group: the group that plays the calls.
            calls: actions and requests to begin an episode.
            pipe: this process's own pipe, for what follows a report.
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
    """Return the decoded reports in data read from the pipe: episode, row, and what follows."""
    return REPORT.iter_unpack(data)

"""Asynchronous batches of the first episodes that are ready, as in EnvPool: no batch waits for the slowest episode.

This process and the workers fill the rows of open blocks in any order. The oldest block is the next batch once it is
full.
"""

import os
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing.connection import Pipe
from multiprocessing.context import BaseContext
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from arramon_client.environments.batches import BLOCKS, BatchLayout, BlockPool, VectorBatch
from arramon_client.environments.group import Call, EpisodeGroup, EpisodeUpdates
from arramon_client.environments.row_writer import ERROR, REPORT, SLOT, UPDATES, RowWriter, reports
from arramon_client.environments.waiter import Waiter
from arramon_client.environments.worker import Worker

MAX_ROWS = 8192
"""Maximum number of free rows: their numbers, 4 bytes each, must fit the buffer of a pipe on every system."""

READ_BYTES = 1024 * REPORT.size

MIN_OWN_SHARE = 0.5
"""Minimum number of rows that this process fills itself, as a fraction of its proportional share of a batch, so that
its episodes are not starved by faster processes."""


@dataclass
class _Block:
    """A block that is being filled.

    Attributes:
        number: number of the block.
        left: number of rows that are not filled yet.
        episodes: episode numbers, by row.
        texts: instructions, by row.
        infos: infos that are not empty, by row.
    """

    number: int
    left: int
    episodes: list[int]
    texts: list[str]
    infos: dict[int, dict[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class ReadyBatch:
    """A batch of episodes that are ready.

    Attributes:
        batch: results of the episodes' latest calls, by row.
        episodes: episode numbers, (rows,) int64.
        texts: instructions, by row.
        infos: infos that are not empty, by row.
    """

    batch: VectorBatch
    episodes: npt.NDArray[np.int64]
    texts: tuple[str, ...]
    infos: dict[int, dict[str, Any]]


class ReadyQueue:
    """Plays calls in several processes, and returns batches of the first episodes that are ready.

    Args:
        space: space of a single observation.
        episodes: total number of episodes.
        rows: number of rows of a batch.
        context: multiprocessing context of the workers; None without workers.
        texts: the current instruction of each episode, updated in place.

    Attributes:
        rows: the row writer that each process uses.
        pending: numbers of the episodes whose latest call has no received result yet.
        is_lost: whether a call failed or was interrupted; some rows are then missing, and all episodes must be reset.
    """

    def __init__(
        self, space: spaces.Dict, episodes: int, rows: int, context: BaseContext | None, texts: list[str]
    ) -> None:
        self._count, self._most_open = rows, -(-episodes // rows)
        layout = BatchLayout(space, rows)
        self._block_pool = BlockPool(layout, context, self._most_open + BLOCKS)
        pipes = (Pipe(duplex=False), Pipe(duplex=False)) if context is None else (
            context.Pipe(duplex=False), context.Pipe(duplex=False)
        )  # fmt: skip
        (free, self._free), (self._filled, filled) = pipes
        self.rows = RowWriter(layout, self._block_pool.blocks, rows, free, filled)
        self.pending: set[int] = set()
        self.is_lost = False
        self._episodes = episodes
        self._texts = texts
        self._open: deque[_Block] = deque()
        self._by_number: dict[int, _Block] = {}
        self._requested_rows = self._opened_rows = 0
        self._calls: list[tuple[int, Call]] = []
        self._to_draw: deque[int] = deque()
        self._own_rows_due = 0.0

    def start(self, group: EpisodeGroup, shares: Sequence[range], workers: Sequence[Worker]) -> None:
        """Set the group and the workers that play the calls.

        Args:
            group: the episodes played in this process.
            shares: episode numbers of each process, this one first.
            workers: the worker processes.
        """
        self._group, self._own, self._workers = group, shares[0], list(workers)
        self._worker_of = {
            number: worker for worker, share in zip(workers, shares[1:], strict=True) for number in share
        }
        self._sentinels = {worker.sentinel: worker for worker in workers}
        self._waiter = Waiter([self._filled.fileno(), *self._sentinels])

    def send(self, calls: Iterable[tuple[int, Call]]) -> None:
        """Play calls, each with the number of an episode that is not pending.

        Raises:
            WorkerDied: if a worker has ended.
        """
        shares: dict[Worker, list[tuple[int, Call]]] = {}
        with self._lost_on_error():
            for number, call in calls:
                self.pending.add(number)
                self._requested_rows += 1
                if number in self._own:
                    self._calls.append((number, call))
                else:
                    shares.setdefault(self._worker_of[number], []).append((number, call))
            while self._opened_rows < self._requested_rows:
                self._open_block()
            for worker, share in shares.items():
                worker.play(share)

    def recv(self) -> ReadyBatch:
        """Wait for a batch of episodes that are ready.

        At least as many episodes must be pending as a batch has rows.

        Raises:
            WorkerDied: if a worker has ended.
            gymnasium.error.Error, ArramonClientError: if a call failed; all episodes must then be reset.
        """
        self._own_rows_due = min(
            self._own_rows_due + MIN_OWN_SHARE * self._count * len(self._own) / self._episodes, self._count
        )
        with self._lost_on_error():
            while self._own_rows_due >= 1.0 and self._play_one():
                pass
            while self._open[0].left:
                self._make_progress()
            return self._lease_block()

    def wait_until_idle(self) -> None:
        """Wait until all pending episodes are ready, without receiving them, and no process is playing.

        Raises:
            WorkerDied, gymnasium.error.Error, ArramonClientError: as for `recv`.
        """
        if self.is_lost:
            self.reset()
            self.is_lost = True  # All episodes still have to be reset.
        with self._lost_on_error():
            while sum(self._count - block.left for block in self._open) < len(self.pending):
                self._make_progress()

    def reset(self) -> None:
        """Wait until no process is playing, and discard all pending calls and results.

        Raises:
            WorkerDied: if a worker has ended.
        """
        self._mark_lost()
        for worker in self._workers:
            worker.discard_answers()
        for pipe, size in ((self._filled, READ_BYTES), (self.rows.free, MAX_ROWS * SLOT.size)):
            while Waiter([pipe.fileno()]).ready():
                os.read(pipe.fileno(), size)
        for block in self._open:
            self._block_pool.release(block.number)
        self._open.clear()
        self._by_number.clear()
        self._calls.clear()
        self._to_draw.clear()
        self._requested_rows = self._opened_rows = 0
        self.is_lost = False

    def close(self) -> None:
        """Close the pipes."""
        for pipe in (self._free, self._filled, self.rows.free, self.rows.filled):
            pipe.close()

    @contextmanager
    def _lost_on_error(self) -> Iterator[None]:
        """Mark the pending calls as lost if the body raises."""
        try:
            yield
        except BaseException:
            self._mark_lost()
            raise

    def _mark_lost(self) -> None:
        """Stop waiting for the pending calls; processes may still play them, until `reset`."""
        self.is_lost = True
        self.pending.clear()

    def _open_block(self) -> None:
        number = self._block_pool.take()
        block = _Block(number, self._count, [0] * self._count, [""] * self._count)
        self._open.append(block)
        self._by_number[number] = block
        self._opened_rows += self._count
        first = number * self._count
        os.write(self._free.fileno(), b"".join(map(SLOT.pack, range(first, first + self._count))))

    def _make_progress(self) -> None:
        """Read reports of filled rows, or else fill one row, or else wait for a report."""
        files = self._waiter.ready()
        if files:
            self._read_reports(files)
        elif not self._play_one():
            self._read_reports(self._waiter.wait())

    def _play_one(self) -> bool:
        """Fill a row in this process; return False if it has no call to play."""
        if not self._to_draw:
            if not self._calls:
                return False
            calls, self._calls = self._calls, []
            self._to_draw.extend(self._group.apply(calls))
        number = self._to_draw.popleft()
        slot, updates = self.rows.draw(self._group, number)
        self._own_rows_due = max(self._own_rows_due - 1.0, -self._count)
        self._record_row(number, slot, updates)
        return True

    def _read_reports(self, files: Sequence[int]) -> None:
        if self._filled.fileno() in files:
            for number, slot, follows in reports(os.read(self._filled.fileno(), READ_BYTES)):
                updates = self._worker_of[number].answer() if follows in (UPDATES, ERROR) else None
                self._record_row(number, slot, updates)
            return
        for file in files:
            raise self._sentinels[file].died_error()

    def _record_row(self, number: int, slot: int, updates: EpisodeUpdates | None) -> None:
        block, row = self._by_number[slot // self._count], slot % self._count
        if updates is not None:
            self._texts[number] = updates.texts.get(number, self._texts[number])
            if number in updates.infos:
                block.infos[row] = updates.infos[number]
        block.episodes[row], block.texts[row] = number, self._texts[number]
        block.left -= 1

    def _lease_block(self) -> ReadyBatch:
        block = self._open.popleft()
        del self._by_number[block.number]
        self._requested_rows -= self._count
        self._opened_rows -= self._count
        # Keep enough blocks for the ones still to be opened, even if the learner keeps all that it holds.
        if self._block_pool.free_count >= self._most_open - len(self._open):
            batch = self._block_pool.lease(block.number)
        else:
            batch = self.rows.layout.over(self.rows.blocks[block.number]).copy()
            self._block_pool.release(block.number)
        episodes = np.array(block.episodes, np.int64)
        self.pending.difference_update(block.episodes)
        return ReadyBatch(batch, episodes, tuple(block.texts), block.infos)

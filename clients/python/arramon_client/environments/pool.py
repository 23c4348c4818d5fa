"""The episodes of a vector environment, divided among this process and worker processes."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from multiprocessing.context import BaseContext
from typing import Any

from arramon_client.environments.batches import BLOCKS, BatchLayout, BlockPool, VectorBatch
from arramon_client.environments.group import EpisodeGroup, EpisodeStart, EpisodeUpdates, VectorSettings
from arramon_client.environments.options import Options
from arramon_client.environments.players import open_backend
from arramon_client.environments.ready_queue import ReadyQueue
from arramon_client.environments.worker import Worker, WorkerTask


class Pool:
    """The episodes of a vector environment, in one process or several.

    Args:
        options: options of the environment.
        settings: settings of the vector environment.
        episodes: number of episodes.
        processes: number of processes, including this one.
        context: multiprocessing context that starts the workers.
        rows: size of the batches that `send` and `recv` use; None without these.

    Attributes:
        group: the episodes played in this process.
        texts: the current instruction of each episode.
        ready: queue behind `send` and `recv`; None without these.
    """

    def __init__(
        self,
        options: Options,
        settings: VectorSettings,
        episodes: int,
        processes: int,
        context: BaseContext,
        rows: int | None,
    ) -> None:
        self._shares = _divide(episodes, processes)
        if processes > 1:
            open_backend(options).prepare()
        self.group = EpisodeGroup(options, self._shares[0], settings)
        self.texts = [""] * episodes
        space = self.group.opened.observation_space()
        shared = context if processes > 1 else None
        layout = BatchLayout(space, episodes)
        self._block_pool = BlockPool(layout, shared, BLOCKS + 1)
        self._spare = self._block_pool.take()
        self._batches = [layout.over(block) for block in self._block_pool.blocks]
        self.ready = None if rows is None else ReadyQueue(space, episodes, rows, shared, self.texts)
        filled = None if self.ready is None else self.ready.rows
        self.workers = [
            Worker(context, WorkerTask(options, numbers, settings, layout, self._block_pool.blocks, filled))
            for numbers in self._shares[1:]
        ]
        if self.ready is not None:
            self.ready.start(self.group, self._shares, self.workers)
        self._has_unread_answers = False
        """Whether workers may have sent answers that were not read because the wait for them was interrupted."""

    def begin(self, calls: Sequence[EpisodeStart | None]) -> tuple[VectorBatch, EpisodeUpdates]:
        """Begin the episodes whose call is not None, and return the batch of all episodes and the updates.

        Raises:
            BadArgument, ResetNeeded: as for `EpisodeGroup.begin`.
        """
        if self.ready is not None and all(call is not None for call in calls):
            self.ready.reset()
        return self._call_all("begin", calls)

    def step(self, actions: Sequence[int]) -> tuple[VectorBatch, EpisodeUpdates]:
        """Apply an action to each episode, and return the batch of all episodes and the updates.

        Raises:
            gymnasium.error.ResetNeeded: if an episode has ended, and the autoreset mode does not begin the next one.
        """
        return self._call_all("step", actions)

    def each(self, method: str, *arguments: object, **named: object) -> list[Any]:
        """Call a method of every `EpisodeGroup`, and return its result for each episode."""
        if self.ready is not None:
            self.ready.wait_until_idle()
        self._discard_answers()
        self._has_unread_answers = True
        for worker in self.workers:
            worker.send_call(method, *arguments, **named)
        own = partial(getattr(self.group, method), *arguments, **named)
        return [value for values in self._answers(own) for value in values]

    def set_attr(self, name: str, values: Sequence[Any]) -> None:
        """Set an attribute of each episode.

        Raises:
            AttributeError: if it cannot be set.
        """
        if self.ready is not None:
            self.ready.wait_until_idle()
        self._discard_answers()
        self._has_unread_answers = True
        for worker, share in zip(self.workers, self._shares[1:], strict=True):
            worker.send_call("set_attr", name, values[share.start : share.stop])
        self._answers(partial(self.group.set_attr, name, values[: self._shares[0].stop]))

    def close(self) -> None:
        """End the worker processes, and close all players."""
        for worker in self.workers:
            worker.close()
        self.workers = []
        if self.ready is not None:
            self.ready.close()
        self.group.close()

    def _call_all(self, method: str, calls: Sequence[Any]) -> tuple[VectorBatch, EpisodeUpdates]:
        """Call a method of all groups, each with its part of the calls; return the batch and the updates."""
        self._discard_answers()
        # The spare block is used while a learner holds all others: it is copied, and never leased.
        number = self._block_pool.take() if self._block_pool.free_count else self._spare
        self._has_unread_answers = True
        for worker, share in zip(self.workers, self._shares[1:], strict=True):
            worker.send_call(method, number, calls[share.start : share.stop])
        try:
            own = partial(getattr(self.group, method), self._batches[number], calls[: self._shares[0].stop])
            answers = self._answers(own)
        except BaseException:
            if number != self._spare:
                self._block_pool.release(number)
            raise
        batch = self._batches[self._spare].copy() if number == self._spare else self._block_pool.lease(number)
        updates = EpisodeUpdates()
        for each in answers:
            if each is not None:
                updates.add(each)
        for episode, text in updates.texts.items():
            self.texts[episode] = text
        return batch, updates

    def _answers(self, own: Callable[[], Any]) -> list[Any]:
        """Return the answers of this process and the workers; an error is raised only after all have answered."""
        answers: list[Any] = []
        errors: list[Exception] = []
        for answer in (own, *(worker.answer for worker in self.workers)):
            try:
                answers.append(answer())
            except Exception as error:  # noqa: BLE001 - raised below
                errors.append(error)
        self._has_unread_answers = False
        if errors:
            raise errors[0]
        return answers

    def _discard_answers(self) -> None:
        if self._has_unread_answers:
            for worker in self.workers:
                worker.discard_answers()
            self._has_unread_answers = False


def _divide(count: int, processes: int) -> list[range]:
    """Return the range of episodes for each process, divided as evenly as possible."""
    ends = [count * number // processes for number in range(processes + 1)]
    return [range(start, end) for start, end in pairwise(ends)]

"""Processes that play shares of a vector environment and write their rows into shared memory."""

import multiprocessing
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.context import BaseContext
from typing import Any

import gymnasium
from gymnasium.vector import AutoresetMode

from arramon_client.environments.batches import Layout
from arramon_client.environments.errors import BadArgument
from arramon_client.environments.group import Group
from arramon_client.environments.options import Options
from arramon_client.errors import ArramonClientError

JOIN_SECONDS = 10.0
"""Time for which a process is waited for that was told to end."""


class WorkerDied(gymnasium.error.Error):
    """A process that plays a share of the episodes ended unexpectedly; its own error is on standard error."""


class Worker:
    """A process that plays a share of the episodes.

    Args:
        context: starts the process.
        options: of all episodes.
        numbers: of the share.
        autoreset: what happens at the end of an episode.
        layout: of a batch.
        blocks: shared memory, for one batch each.
    """

    def __init__(
        self,
        context: BaseContext,
        options: Options,
        numbers: range,
        autoreset: AutoresetMode,
        layout: Layout,
        blocks: Sequence[Any],
    ) -> None:
        self._pipe, other = context.Pipe()
        self._process = context.Process(  # type: ignore[attr-defined]  # every context has it
            target=_play,
            args=(other, options, numbers, autoreset, layout, blocks),
            name="arramon-episodes",
            daemon=True,
        )
        self._process.start()
        other.close()

    @property
    def process_id(self) -> int:
        """Id of the process."""
        return int(self._process.pid)

    def write(self, method: str, block: int, *arguments: object) -> None:
        """Call a method of the group, `begin` or `step`, with the arrays over a block as its first argument.

        Raises:
            WorkerDied: if the process has ended.
        """
        self._send((method, block, arguments))

    def ask(self, method: str, *arguments: object) -> None:
        """Call any other method of the group.

        Raises:
            WorkerDied: if the process has ended.
        """
        self._send((method, None, arguments))

    def answer(self) -> Any:
        """Wait for the answer to the latest call.

        Raises:
            WorkerDied: if the process has ended.
            gymnasium.error.Error, ArramonClientError: as the method raised it there.
        """
        try:
            answer = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise self._death() from error
        if isinstance(answer, Exception):
            raise answer
        return answer

    def close(self) -> None:
        """End the process."""
        with suppress(OSError):  # It has ended before.
            self._pipe.send(None)
        self._process.join(JOIN_SECONDS)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()

    def _send(self, call: tuple[str, int | None, tuple[object, ...]]) -> None:
        try:
            self._pipe.send(call)
        except OSError as error:
            raise self._death() from error

    def _death(self) -> WorkerDied:
        self._process.join(JOIN_SECONDS)
        return WorkerDied(
            f"a process that plays episodes ended with status {self._process.exitcode}; close the environment"
        )


def _play(
    pipe: "Connection[Any, Any]",
    options: Options,
    numbers: range,
    autoreset: AutoresetMode,
    layout: Layout,
    blocks: Sequence[Any],
) -> None:
    """Answer calls until told to end, or until the other process has ended."""
    batches = [layout.over(block) for block in blocks]
    group = Group(options, numbers, autoreset)
    try:
        while (asked := pipe.recv()) is not None:
            method, block, arguments = asked
            try:
                written = () if block is None else (batches[block],)
                pipe.send(getattr(group, method)(*written, *arguments))
            except (gymnasium.error.Error, ArramonClientError) as error:
                pipe.send(error)
    except (EOFError, KeyboardInterrupt):
        pass
    finally:
        group.close()


def context_of(name: str | None) -> BaseContext:
    """Return the context that starts processes: "fork", "spawn", "forkserver", or None for the system's default.

    Raises:
        BadArgument: if there is no such context.
    """
    there = multiprocessing.get_all_start_methods()
    if name is not None and name not in there:
        raise BadArgument(f"context is {name!r}, expected None, {', '.join(map(repr, there))}")
    return multiprocessing.get_context(name)

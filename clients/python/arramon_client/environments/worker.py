"""Processes that play shares of a vector environment and write their rows into shared memory."""

import multiprocessing
import pickle
import signal
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import BaseContext
from typing import Any

import gymnasium

from arramon_client.environments.batches import BatchLayout
from arramon_client.environments.errors import BadArgument
from arramon_client.environments.group import Call, EpisodeGroup, VectorSettings
from arramon_client.environments.options import Options
from arramon_client.environments.rows import RowWriter
from arramon_client.environments.waiter import Waiter
from arramon_client.errors import ArramonClientError
from arramon_client.local.lifeline import end_with_parent

JOIN_SECONDS = 10.0
"""Time for which a process is waited for that was told to end."""

SYNC = "sync"
"""A call whose answer is itself, with its number."""


class WorkerDied(gymnasium.error.Error):
    """A process that plays a share of the episodes ended unexpectedly; its own error is on standard error."""


@dataclass(frozen=True)
class WorkerTask:
    """What a process plays.

    Attributes:
        options: of all episodes.
        numbers: of those of the process.
        settings: of all episodes.
        layout: of a batch.
        blocks: shared memory, for one batch each.
        rows: of batches of the first that are ready; None if there are none.
    """

    options: Options
    numbers: range
    settings: VectorSettings
    layout: BatchLayout
    blocks: Sequence[Any]
    rows: RowWriter | None


class Worker:
    """A process that plays a share of the episodes.

    Args:
        context: starts the process.
        task: what it plays.
    """

    def __init__(self, context: BaseContext, task: WorkerTask) -> None:
        self._pipe, other = context.Pipe()
        self._waiter = Waiter([self._pipe.fileno()])
        self._syncs = 0
        self._process = context.Process(  # type: ignore[attr-defined]  # every context has it
            target=_play, args=(other, task), name="arramon-episodes", daemon=True
        )
        self._process.start()
        other.close()

    @property
    def process_id(self) -> int:
        """Id of the process."""
        return int(self._process.pid)

    @property
    def sentinel(self) -> int:
        """A file that can be read once the process has ended."""
        return int(self._process.sentinel)

    def send_call(self, method: str, *arguments: object, **named: object) -> None:
        """Call a method of the group, whose answer `answer` returns; `begin` and `step` with the number of a block.

        Raises:
            WorkerDied: if the process has ended.
            BadArgument: if an argument cannot be sent to a process.
        """
        try:
            self._pipe.send_bytes(pickle.dumps((method, arguments, named)))
        except OSError as error:
            raise self.died_error() from error
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise BadArgument(f"{arguments!r} cannot be sent to a process: {error}") from error

    def play(self, calls: Sequence[tuple[int, Call]]) -> None:
        """Let the process play calls, each with the number of its episode; it fills rows, and answers nothing.

        Raises:
            WorkerDied: if the process has ended.
        """
        self.send_call("play", calls)

    def answer(self) -> Any:
        """Wait for the answer to the latest call, or for what is told of a row.

        Raises:
            WorkerDied: if the process has ended.
            gymnasium.error.Error, ArramonClientError: as the method raised it there.
            Exception: as a method of `Member` raised it, for `call` and `set_attr`.
        """
        answer = self._receive()
        if isinstance(answer, Exception):
            raise answer
        return answer

    def discard_answers(self) -> None:
        """Wait until the process has nothing more to do, and forget all that it has answered.

        Raises:
            WorkerDied: if the process has ended.
        """
        self._syncs += 1
        self.send_call(SYNC, self._syncs)
        while self._receive() != (SYNC, self._syncs):  # An earlier one is left if the wait for it was interrupted.
            pass

    def close(self) -> None:
        """End the process."""
        with suppress(OSError):  # It has ended before.
            self._pipe.send_bytes(pickle.dumps(None))
        self._drain()
        self._process.join(JOIN_SECONDS)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()

    def died_error(self) -> WorkerDied:
        """Return the error that says that the process has ended."""
        self._process.join(JOIN_SECONDS)
        return WorkerDied(
            f"a process that plays episodes ended with status {self._process.exitcode}; close the environment"
        )

    def _drain(self) -> None:
        """Read what the process still tells, until it ends: it cannot, while it waits for a reader."""
        left = time.monotonic() + JOIN_SECONDS
        while (seconds := left - time.monotonic()) > 0:
            if self._pipe not in wait([self._pipe, self._process.sentinel], seconds):
                return  # It has ended, though others hold its end of the pipe, or goes on for too long.
            try:
                self._pipe.recv_bytes()
            except (EOFError, OSError):
                return

    def _receive(self) -> Any:
        self._waiter.wait()
        try:
            return self._pipe.recv()
        except (EOFError, OSError) as error:
            raise self.died_error() from error


def _play(pipe: "Connection[Any, Any]", task: WorkerTask) -> None:
    """Answer calls until told to end; end at once with the other process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # An interrupt from the keyboard is the other process's to handle.
    end_with_parent()
    batches = [task.layout.over(block) for block in task.blocks]
    group = EpisodeGroup(task.options, task.numbers, task.settings)
    waiter = Waiter([pipe.fileno()])
    try:
        while True:
            waiter.wait()
            message = pickle.loads(pipe.recv_bytes())  # noqa: S301 - from the process that started this one
            if message is None:
                return
            method, arguments, named = message
            if method == SYNC:
                pipe.send((SYNC, *arguments))
                continue
            if method == "play":
                assert task.rows is not None
                task.rows.fill(group, arguments[0], pipe)
                continue
            if method in ("begin", "step"):
                arguments = (batches[arguments[0]], *arguments[1:])
            pipe.send(_answer(group, method, arguments, named))
    except EOFError:
        pass
    finally:
        group.close()


def _answer(group: EpisodeGroup, method: str, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
    """Return what a method of the group returns, or the error that it raises, to be raised in the other process."""
    try:
        answer = getattr(group, method)(*arguments, **named)
    except (gymnasium.error.Error, ArramonClientError) as error:
        return error
    except Exception as error:
        if method in ("call", "set_attr"):  # A program's own attributes may raise anything.
            return error
        raise
    if method == "call":
        try:
            pickle.dumps(answer)
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            return BadArgument(
                f"{arguments[0]!r} cannot be passed between processes ({error}); with processes=1 it can be had"
            )
    return answer


def context_of(name: str | None) -> BaseContext:
    """Return the context that starts processes: "fork", "spawn", "forkserver", or None for the system's default.

    Raises:
        BadArgument: if there is no such context.
    """
    there = multiprocessing.get_all_start_methods()
    if name is not None and name not in there:
        raise BadArgument(f"context is {name!r}, expected None, {', '.join(map(repr, there))}")
    return multiprocessing.get_context(name)

"""Worker processes of a vector environment, which play some episodes and write their rows to shared memory."""

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
from arramon_client.environments.row_writer import RowWriter
from arramon_client.environments.waiter import Waiter
from arramon_client.errors import ArramonClientError
from arramon_client.local.lifeline import end_with_parent

JOIN_SECONDS = 10.0
"""Time to wait for a process to exit after it was told to."""

SYNC = "sync"
"""Name of a call that a worker answers with the call itself, to synchronise."""


class WorkerDied(gymnasium.error.Error):
    """A worker process ended unexpectedly; its own error is on standard error."""


@dataclass(frozen=True)
class WorkerTask:
    """The task of one worker process.

    Attributes:
        options: options of the environment.
        numbers: numbers of the worker's episodes.
        settings: settings of the vector environment.
        layout: layout of a batch.
        blocks: blocks of shared memory, each for one batch.
        rows: row writer for asynchronous batches; None without these.
    """

    options: Options
    numbers: range
    settings: VectorSettings
    layout: BatchLayout
    blocks: Sequence[Any]
    rows: RowWriter | None


class Worker:
    """A worker process, seen from the process that started it.

    Args:
        context: multiprocessing context that starts the process.
        task: what the process plays.
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
        """File descriptor that can be read once the process has ended."""
        return int(self._process.sentinel)

    def send_call(self, method: str, *arguments: object, **named: object) -> None:
        """Call a method of the worker's group; `answer` returns the result. `begin` and `step` take a block's number.

        Raises:
            WorkerDied: if the process has ended.
            BadArgument: if an argument cannot be pickled.
        """
        try:
            self._pipe.send_bytes(pickle.dumps((method, arguments, named)))
        except OSError as error:
            raise self.died_error() from error
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise BadArgument(f"{arguments!r} cannot be sent to a process: {error}") from error

    def play(self, calls: Sequence[tuple[int, Call]]) -> None:
        """Send calls, each with the number of its episode; the worker fills rows with the results, without an answer.

        Raises:
            WorkerDied: if the process has ended.
        """
        self.send_call("play", calls)

    def answer(self) -> Any:
        """Wait for the answer to the latest call, or for what follows the report of a row.

        Raises:
            WorkerDied: if the process has ended.
            gymnasium.error.Error, ArramonClientError: if the method raised it in the worker.
            Exception: if `call` or `set_attr` raised it in the worker.
        """
        answer = self._receive()
        if isinstance(answer, Exception):
            raise answer
        return answer

    def discard_answers(self) -> None:
        """Wait until the process is idle, and discard its answers.

        Raises:
            WorkerDied: if the process has ended.
        """
        self._syncs += 1
        self.send_call(SYNC, self._syncs)
        while self._receive() != (SYNC, self._syncs):  # Earlier ones remain if a wait for them was interrupted.
            pass

    def close(self) -> None:
        """End the process."""
        with suppress(OSError):  # The process has already ended.
            self._pipe.send_bytes(pickle.dumps(None))
        self._drain()
        self._process.join(JOIN_SECONDS)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()

    def died_error(self) -> WorkerDied:
        """Return the error that reports the end of the process."""
        self._process.join(JOIN_SECONDS)
        return WorkerDied(
            f"a process that plays episodes ended with status {self._process.exitcode}; close the environment"
        )

    def _drain(self) -> None:
        """Read the pipe until the process ends: it cannot exit while a write blocks."""
        left = time.monotonic() + JOIN_SECONDS
        while (seconds := left - time.monotonic()) > 0:
            if self._pipe not in wait([self._pipe, self._process.sentinel], seconds):
                return  # The process has ended, although others hold its end of the pipe, or takes too long.
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
    """Answer calls until told to stop; exit at once when the parent process ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # The parent process handles keyboard interrupts.
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
    """Return the result of a method of the group, or the exception that it raised, for the parent process."""
    try:
        answer = getattr(group, method)(*arguments, **named)
    except (gymnasium.error.Error, ArramonClientError) as error:
        return error
    except Exception as error:
        if method in ("call", "set_attr"):  # Attributes that a program has set may raise anything.
            return error
        raise
    if method == "call":
        try:
            pickle.dumps(answer)
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            return BadArgument(f"{arguments[0]!r} cannot be passed between processes ({error}); use processes=1")
    return answer


def context_of(name: str | None) -> BaseContext:
    """Return the multiprocessing context with this start method; None for the system's default.

    Raises:
        BadArgument: if the start method is not available.
    """
    there = multiprocessing.get_all_start_methods()
    if name is not None and name not in there:
        raise BadArgument(f"context is {name!r}, expected None, {', '.join(map(repr, there))}")
    return multiprocessing.get_context(name)

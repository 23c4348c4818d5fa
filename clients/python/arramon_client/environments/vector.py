"""The vector environment: many episodes in one process, or in several with images in shared memory."""

import os
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv

from arramon_client.environments.arguments import is_whole_number, whole_number
from arramon_client.environments.call_checks import check_actions, episode_numbers, episode_starts
from arramon_client.environments.conversion import keep_texts_in_wrappers
from arramon_client.environments.errors import BadArgument
from arramon_client.environments.lockstep import OWN_ARGUMENTS, LockstepVectorEnv, VectorStep
from arramon_client.environments.ready_queue import MAX_ROWS, ReadyQueue
from arramon_client.environments.single import room_options


class ArraMonVectorEnv(LockstepVectorEnv):
    """The benchmark as a vector environment; `gymnasium.make_vec("arramon/ArraMon-v0", num_envs=16)` makes one.

    Observations are those of `ArraMonEnv` in arrays of (num_envs, ...); `instruction` is a tuple of texts. Returned
    arrays are never overwritten: a block of memory is reused only once no array views it.

    `step` waits for all episodes. With `batch_size`, `send` and `recv` are also available, which wait for the first
    episodes that are ready, as in EnvPool. The same actions lead to the same observations of an episode either way,
    whatever the order of batches and the number of processes.

    Args:
        num_envs: number of episodes played at once.
        processes: number of processes, including this one; with 1 no process is started.
        autoreset_mode: Gymnasium's autoreset mode.
        context: start method of processes: "fork", "spawn", "forkserver", or None for the system's default.
        render_mode: None or "rgb_array".
        batch_size: number of episodes that `recv` waits for, 1 to num_envs; None disables `send` and `recv`.
        max_episode_steps: number of actions after which an episode is truncated; None for no limit. The limit is not
            part of the benchmark's rules, and a truncated episode has no scores.
        options: the fields of `arramon_client.environments.options.Options`.

    Raises:
        BadArgument: if an argument is wrong; the message states what was expected.
        NoBackend: if no host is named, and the server package is not installed.

    Attributes:
        tokenizer: tokenizer of the instructions.
    """

    def __init__(
        self,
        num_envs: int = 1,
        processes: int = 1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        context: str | None = None,
        render_mode: str | None = None,
        batch_size: int | None = None,
        max_episode_steps: int | None = None,
        **options: object,
    ) -> None:
        count = whole_number("num_envs", num_envs, "at least 1", 1)
        rows = None if batch_size is None else _rows(batch_size, count)
        super().__init__(count, processes, autoreset_mode, context, render_mode, max_episode_steps, rows, options)
        self._infos_of_rows = _RowInfos(rows or 1)

    def async_reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> None:
        """Begin episodes like `reset`, without waiting: `recv` returns their first observations, with rewards of 0.

        Raises:
            BadArgument: as for `reset`; for an unknown episode, `recv` raises it.
            gymnasium.error.AlreadyPendingCallError: if only some begin, and one of them has a result to be received.
            gymnasium.error.ResetNeeded: if the mask leaves out episodes before all have begun.
        """
        ready = self._queue("async_reset")
        keep_texts_in_wrappers()
        calls = episode_starts(self.num_envs, seed, options)
        mask = np.array([call is not None for call in calls])
        if mask.all():
            ready.reset()
        elif not self._has_begun:
            raise gymnasium.error.ResetNeeded("the first reset must begin all episodes, without a mask")
        else:
            _check_received(ready, np.flatnonzero(mask).tolist())
        self._has_begun = True
        self._over[mask] = False
        ready.send([(number, call) for number, call in enumerate(calls) if call is not None])

    def send(self, actions: npt.NDArray[np.int64], env_id: npt.NDArray[np.int64] | Sequence[int] | None = None) -> None:
        """Apply actions to some episodes without waiting for the results, which `recv` returns.

        Args:
            actions: one action for each of these episodes.
            env_id: numbers of the episodes, as in `infos["env_id"]`; None for all.

        Raises:
            BadArgument: if there is no such episode, or one is repeated.
            gymnasium.error.InvalidAction: if an action is not 0 to 3, or the number of actions is wrong.
            gymnasium.error.AlreadyPendingCallError: if an episode still has a result to be received.
            gymnasium.error.ResetNeeded, gymnasium.error.ClosedEnvironmentError: as for `step`.
        """
        ready = self._queue("send")
        numbers = episode_numbers(env_id, self.num_envs)
        each = check_actions(actions, len(numbers))
        self._check_begun(numbers)
        _check_received(ready, numbers)
        ready.send(list(zip(numbers, each, strict=True)))

    def recv(self) -> VectorStep:
        """Wait for the first `batch_size` episodes that are ready, and return the results of their latest calls.

        Returns:
            Observations, rewards, terminated, truncated and infos in arrays of (batch_size, ...), and in
            `infos["env_id"]` the numbers of the episodes, (batch_size,) int64.

        Raises:
            gymnasium.error.NoAsyncCallError: if fewer than `batch_size` episodes have a result to be received.
            BadArgument: if `async_reset` named an unknown episode; all episodes must then be reset.
            gymnasium.error.ClosedEnvironmentError: if the environment was closed.
        """
        ready, size = self._queue("recv"), self._infos_of_rows.num_envs
        sent = len(ready.pending)
        if sent < size:
            raise gymnasium.error.NoAsyncCallError(
                f"recv() waits for {size} episodes (batch_size), but {sent} have a call whose result is to be received;"
                " call send() or async_reset()",
                "recv",
            )
        found = ready.recv()
        infos = self._infos_of_rows.of(found.infos)
        infos["env_id"] = found.episodes
        return self._outcome(found.batch, found.texts, found.episodes, infos)

    def _queue(self, method: str) -> ReadyQueue:
        """Return the queue behind `send` and `recv`, after checking that it can be used."""
        self._check_open(method)
        if self._pool.ready is None:
            raise BadArgument(
                f"{method}() needs batch_size: make_vec(..., batch_size=N) waits for the first N episodes"
            )
        self._check_lost(self._pool.ready)
        return self._pool.ready

    def _check_lost(self, ready: ReadyQueue) -> None:
        """Require a reset of all episodes if a call failed or was interrupted, as rows may be lost."""
        if ready.is_lost:
            self._has_begun = False

    def _check_settled(self, method: str) -> None:
        ready = self._pool.ready
        if ready is None:
            return
        self._check_lost(ready)
        if ready.is_lost:
            raise gymnasium.error.ResetNeeded(
                "a call failed or was interrupted before its results were received; call reset() or async_reset() for"
                " all episodes, without a mask"
            )
        if ready.pending:
            raise gymnasium.error.AlreadyPendingCallError(
                f"{method}() was called while the results of {sorted(ready.pending)} are to be received with recv()",
                "recv",
            )


class _RowInfos(VectorEnv[Any, Any, Any]):
    """Merges the infos of a batch's rows in Gymnasium's format."""

    def __init__(self, rows: int) -> None:
        self.num_envs = rows

    def of(self, by_row: dict[int, dict[str, Any]]) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        for row in sorted(by_row):
            infos = self._add_info(infos, by_row[row], row)
        return infos


def make_vector(num_envs: int = 1, **arguments: Any) -> ArraMonVectorEnv:
    """Return the vector environment, for `gymnasium.make_vec`."""
    return ArraMonVectorEnv(num_envs, **arguments)


def make_room_vector(num_envs: int = 1, **arguments: Any) -> ArraMonVectorEnv:
    """Return the vector environment of tasks in the assembly room alone, for `gymnasium.make_vec`."""
    own: dict[str, Any] = {name: arguments.pop(name) for name in OWN_ARGUMENTS if name in arguments}
    options: dict[str, Any] = room_options(arguments, OWN_ARGUMENTS)
    return ArraMonVectorEnv(num_envs, **own, **options)


def _check_received(ready: ReadyQueue, episodes: Sequence[int]) -> None:
    """Raise AlreadyPendingCallError if one of the episodes has a result to be received."""
    pending = ready.pending.intersection(episodes)
    if pending:
        raise gymnasium.error.AlreadyPendingCallError(
            f"the results of {sorted(pending)} are to be received with recv() before they can be called again", "recv"
        )


def _rows(batch_size: int, count: int) -> int:
    """Return the checked batch size.

    Raises:
        BadArgument: if it is not 1 to the number of episodes, or the system does not support it.
    """
    if not is_whole_number(batch_size) or not 1 <= batch_size <= count:
        raise BadArgument(f"batch_size is {batch_size!r}, expected None or 1 to num_envs, which is {count}")
    if batch_size + count > MAX_ROWS:
        raise BadArgument(f"the sum of num_envs and batch_size is {batch_size + count}, expected at most {MAX_ROWS}")
    if os.name != "posix":
        raise BadArgument("batch_size needs a Unix system: leave it out, and use step()")
    return int(batch_size)

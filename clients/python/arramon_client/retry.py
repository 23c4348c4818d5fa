"""Waiting for a server that is away, and asking it again."""

import random
import time
from collections.abc import Callable
from typing import TypeVar

from arramon_client.connection import call
from arramon_client.errors import ServerUnreachableError

Answer = TypeVar("Answer")

FIRST_DELAY, LAST_DELAY = 0.1, 2.0
"""Seconds between attempts to reconnect, from the first to the longest; each is shortened by chance by up to a half."""

PATIENCE = 300.0
"""Seconds without anything new from the server after which it is given up."""


def ask(
    method: Callable[..., Answer],
    request: object,
    address: str,
    retry: "Retry",
    revive: Callable[[], None] = lambda: None,
) -> Answer:
    """A unary call that may be made again, as it changes nothing, until the server answers.

    Args:
        method, request, address: as for `call`.
        retry: how long to wait.
        revive: is called before each further attempt.

    Raises:
        ServerUnreachableError: if it stays away for longer than the patience.
        ArramonClientError: as `call`.
    """
    while True:
        try:
            answer = call(method, request, address)
        except ServerUnreachableError as error:
            retry.wait(str(error))
            revive()
        else:
            retry.succeeded()
            return answer


class Retry:
    """Waits between attempts to reconnect, longer each time, until patience runs out."""

    def __init__(self, run_id: str, patience: float, notify: Callable[[str], None]) -> None:
        self._run_id, self._patience, self._notify = run_id, patience, notify
        self._lost_at: float | None = None
        self._told = False
        self._delay = FIRST_DELAY

    def succeeded(self) -> None:
        """The server said something new."""
        if self._lost_at is not None and self._told:
            self._notify(f"connected again after {time.monotonic() - self._lost_at:.1f} s")
        self._lost_at, self._told, self._delay = None, False, FIRST_DELAY

    def wait_for(self, error: ServerUnreachableError) -> None:
        """As `wait`, for a server that was not there at the first call."""
        self._wait(str(error), f"no connection yet ({error})")

    def wait(self, reason: str, *, quiet: bool = False) -> None:
        """Waits for the next attempt.

        Args:
            reason: why there is to be one.
            quiet: whether a first attempt is nothing that a participant should read: a server that ends a stream in
                good order, as a process of it drains, most often has another.

        Raises:
            ServerUnreachableError: if patience has run out.
        """
        self._wait(reason, f"the connection is lost ({reason})", quiet=quiet)

    def _wait(self, reason: str, notice: str, *, quiet: bool = False) -> None:
        now = time.monotonic()
        if self._lost_at is None:
            self._lost_at = now
        if not (self._told or (quiet and self._lost_at == now)):
            self._told = True
            self._notify(f"{notice}; trying again")
        if now - self._lost_at >= self._patience:
            raise ServerUnreachableError(
                f"the server was away for {now - self._lost_at:.0f} s ({reason}); "
                f"nothing of run {self._run_id} is lost: go on with --resume {self._run_id}"
            )
        time.sleep(self._delay * random.uniform(0.5, 1.0))  # noqa: S311 - spreads the clients of a server that restarts
        self._delay = min(2 * self._delay, LAST_DELAY)

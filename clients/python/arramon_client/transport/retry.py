"""Retries of calls and reconnections, with growing delays and a time limit."""

import random
import time
from collections.abc import Callable
from typing import TypeVar

from arramon_client.errors import ServerUnreachableError
from arramon_client.transport.connection import call

Answer = TypeVar("Answer")

FIRST_DELAY, LAST_DELAY = 0.1, 2.0
"""Shortest and longest delay in seconds between attempts to reconnect; each is randomly shortened by up to half."""

QUIET_ATTEMPTS = 6
"""Number of attempts in a row after which the participant is notified although their failure is to be expected. Every
other one may go to a process that has ended, and the first one elsewhere may still reach that process."""

PATIENCE = 300.0
"""Seconds without progress after which the client gives up."""


def call_until_answered(
    method: Callable[..., Answer],
    request: object,
    address: str,
    retry: "Retry",
    revive: Callable[[], None] = lambda: None,
) -> Answer:
    """Make a read-only unary call, retrying until the server answers.

    Args:
        method, request, address: as for `call`.
        retry: delays and time limit.
        revive: called before each further attempt.

    Raises:
        ServerUnreachableError: if the server is away for longer than the patience.
        ArramonClientError: as for `call`.
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
    """Delays between attempts to reconnect, growing each time, up to a time limit (the patience).

    Args:
        run_id: id of the run, for messages.
        patience: the time limit, in seconds.
        notify: called with messages for the participant.
        sleep: waits for some seconds, or less if the attempts are to end.
    """

    def __init__(
        self,
        run_id: str,
        patience: float,
        notify: Callable[[str], None],
        sleep: Callable[[float], object] = time.sleep,
    ) -> None:
        self._run_id, self._patience, self._notify, self._sleep = run_id, patience, notify, sleep
        self._lost_at: float | None = None
        self._notified = False
        self._attempts = 0
        self._delay = FIRST_DELAY

    def succeeded(self) -> None:
        """Reset the delays after the server sent something new."""
        if self._lost_at is not None and self._notified:
            self._notify(f"reconnected after {time.monotonic() - self._lost_at:.1f} s")
        self._lost_at, self._notified, self._attempts, self._delay = None, False, 0, FIRST_DELAY

    def wait_for(self, error: ServerUnreachableError) -> None:
        """Wait before the next attempt to reach a server that has not answered yet."""
        self._wait(str(error), f"no connection yet ({error})")

    def wait(self, reason: str, *, quiet: bool = False) -> None:
        """Wait before the next attempt.

        Args:
            reason: why the connection was lost, for the message.
            quiet: whether this failure is to be expected while one of several server processes shuts down: another one
                usually answers at once, so that the participant is notified only after QUIET_ATTEMPTS attempts.

        Raises:
            ServerUnreachableError: if the patience is exhausted.
        """
        self._wait(reason, f"connection lost ({reason})", quiet=quiet)

    def _wait(self, reason: str, notice: str, *, quiet: bool = False) -> None:
        now = time.monotonic()
        if self._lost_at is None:
            self._lost_at = now
        self._attempts += 1
        if not (self._notified or (quiet and self._attempts < QUIET_ATTEMPTS)):
            self._notified = True
            self._notify(f"{notice}; retrying")
        if now - self._lost_at >= self._patience:
            raise ServerUnreachableError(
                f"the server was unreachable for {now - self._lost_at:.0f} s ({reason}); "
                f"run {self._run_id} is saved: resume it with --resume {self._run_id}"
            )
        self._sleep(self._delay * random.uniform(0.5, 1.0))  # noqa: S311 - so that clients do not all reconnect at once
        self._delay = min(2 * self._delay, LAST_DELAY)

"""Signals that stop the client: SIGTERM (`timeout`, Slurm, `docker stop`) and SIGHUP do what Ctrl-C does."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals that stop the client in order, besides SIGINT; Windows has no SIGHUP."""


class Stopped(KeyboardInterrupt):
    """A signal asked the client to stop. It passes all handlers of exceptions, as Ctrl-C does.

    Attributes:
        signal: the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.signal = signal.Signals(number)


@contextmanager
def stopped_by_signals() -> Iterator[None]:
    """Raise Stopped in the main thread when a signal asks the client to stop, until the end of the context.

    Signals that are ignored (`nohup`) or handled by the program that uses this client are left alone. Only the first is
    acted upon: `timeout` sends two at once.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in SIGNALS}
    taken = [number for number in SIGNALS if before[number] is signal.SIG_DFL]

    owner = os.getpid()

    def stop(number: int, _: FrameType | None) -> None:
        if os.getpid() != owner:  # A process that the agent forked, for which the signal has its usual meaning.
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
            return
        for each in taken:
            signal.signal(each, signal.SIG_IGN)
        raise Stopped(number)

    for number in taken:
        signal.signal(number, stop)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, before[number])


def describe(stop: KeyboardInterrupt) -> str:
    """Return what stopped the client, for the participant."""
    return f"stopped by {stop.signal.name}" if isinstance(stop, Stopped) else "interrupted"


def status_of(stop: KeyboardInterrupt) -> int:
    """Return the exit status after a signal: 128 and its number, such as 143 for SIGTERM."""
    return 128 + (stop.signal if isinstance(stop, Stopped) else signal.SIGINT)

"""Signal handling: SIGTERM (`timeout`, Slurm, `docker stop`) and SIGHUP stop the client like Ctrl-C."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals other than SIGINT that stop the client; Windows has no SIGHUP."""

SIGNAL_SECONDS = 0.5
"""Longest wait of the main thread in one piece: a signal that the system delivers to another thread, such as one of
gRPC's, does not end the wait, and its handler runs only when the main thread goes on."""


class Stopped(KeyboardInterrupt):
    """Raised when a signal stops the client; like Ctrl-C, it is not caught by `except Exception`.

    Attributes:
        signal: the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.signal = signal.Signals(number)


@contextmanager
def stopped_by_signals() -> Iterator[None]:
    """Raise Stopped in the main thread when a signal arrives, until the end of the context.

    Signals that are ignored (`nohup`) or handled by the program that uses this client are not changed. Only the first
    signal has an effect: `timeout` sends two at once.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in SIGNALS}
    taken = [number for number in SIGNALS if before[number] is signal.SIG_DFL]

    owner = os.getpid()

    def stop(number: int, _: FrameType | None) -> None:
        if os.getpid() != owner:  # In a process that the agent forked, the signal has its default effect.
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
    """Describe what stopped the client, for the participant."""
    return f"stopped by {stop.signal.name}" if isinstance(stop, Stopped) else "interrupted"


def status_of(stop: KeyboardInterrupt) -> int:
    """Return the exit status after a signal: 128 plus its number, such as 143 for SIGTERM."""
    return 128 + (stop.signal if isinstance(stop, Stopped) else signal.SIGINT)

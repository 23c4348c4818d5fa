"""Signals that whoever started the tests has set to be ignored, as `nohup` and a shell's `&` do.

A program inherits it, and every program that it starts: one under test would not be stopped by such a signal, and the
test would wait for its end for ever.
"""

import signal

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
"""Signals that stop programs under test."""


def let_programs_be_stopped() -> None:
    """Let programs that this process starts from now on be stopped by signals; itself it goes on to ignore them."""
    for number in SIGNALS:
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, _ignore)  # A handler, unlike SIG_IGN, is not inherited by a program.


def _ignore(*_: object) -> None:
    pass

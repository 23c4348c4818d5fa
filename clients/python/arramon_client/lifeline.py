"""Runs `python -m server` until its parent is gone: the embedded server must not outlive a client that was killed.

The parent holds the other end of this process's standard input open and never writes to it. When the parent ends, in
whatever way, standard input ends, and this process asks itself to stop as an operator would.
"""

import os
import runpy
import signal
import sys
import threading


def _stop_at_end_of_input() -> None:
    while os.read(0, 1):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


def main(arguments: list[str]) -> None:
    """Runs the module `arguments[0]` as a program, with the rest as its arguments."""
    threading.Thread(target=_stop_at_end_of_input, name="lifeline", daemon=True).start()
    sys.argv = arguments
    runpy.run_module(arguments[0], run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main(sys.argv[1:])

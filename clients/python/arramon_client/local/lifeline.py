"""Launcher of a module that stops when its parent process ends, so that it does not outlive a client that is killed.

The parent keeps the other end of this process's standard input open and never writes to it. When the parent ends, for
whatever reason, standard input ends, and this process sends itself SIGTERM.
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
    """Run the module `arguments[0]` as a program, with the remaining arguments."""
    threading.Thread(target=_stop_at_end_of_input, name="lifeline", daemon=True).start()
    sys.argv = arguments
    runpy.run_module(arguments[0], run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main(sys.argv[1:])

"""Entry point of `arramon-server` and `python -m server`, which handles SIGTERM before loading anything else."""

import gc
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status, as `arramon_server.cli.main` does."""
    if os.name != "posix":  # The server locks files, listens on Unix sockets, and handles signals.
        sys.stderr.write("error: arramon-server needs Linux or macOS: on Windows run it in WSL 2\n")
        return 2
    words = sys.argv[1:] if argv is None else argv
    with _exit_on_sigterm() if words[:1] == ["serve"] else nullcontext():
        with _no_garbage_collection():
            from arramon_server import cli  # takes up to a second, during which the server can already be stopped

            cli.load(words)
        return cli.main(words)


@contextmanager
def _exit_on_sigterm() -> Iterator[None]:
    """Exit with status 0 on SIGTERM during startup, while there is nothing to drain."""

    def leave(*_: object) -> None:
        sys.exit(0)

    before = signal.signal(signal.SIGTERM, leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Disable garbage collection while loading modules, and exclude them from it later: it is slower than loading."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


if __name__ == "__main__":
    sys.exit(main())

"""Entry point of `arramon-server` and `python -m server`: handles SIGTERM before anything else is loaded."""

import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status, as `server.cli.main` does."""
    words = sys.argv[1:] if argv is None else argv
    with _exit_on_sigterm() if words[:1] == ["serve"] else nullcontext():
        from server.cli import main as run  # takes up to a second, in which a server can be stopped already

        return run(words)


@contextmanager
def _exit_on_sigterm() -> Iterator[None]:
    """Exit with status 0 on SIGTERM during the start, when there is nothing to drain yet."""

    def leave(*_: object) -> None:
        sys.exit(0)

    before = signal.signal(signal.SIGTERM, leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


if __name__ == "__main__":
    sys.exit(main())

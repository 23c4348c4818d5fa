"""The embedded server for a client that plays: episodes are generated if there are none, and clocks are off."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

from arramon_client.local.embedded import SERVER, EmbeddedServer, check_installed, default_data, embedded_server
from arramon_client.local.first_episodes import SPLIT, holds_episodes, make_episodes


def embedded_for_play(
    data: Path | None,
    notify: Callable[[str], None],
    *,
    workers: int = 1,
    needs_episodes: bool = True,
    quiet: bool = False,
    more: Sequence[str] = (),
) -> AbstractContextManager[EmbeddedServer]:
    """Return an embedded server as a context.

    Args:
        data: its data folder; None for the default.
        notify: called with messages for the participant.
        workers: number of its worker processes.
        needs_episodes: whether to generate a small split if the folder has none.
        quiet: show no progress of that.
        more: further arguments of the server.

    Raises:
        EmbeddedServerError: if the server is not installed, does not start, or cannot generate episodes.
    """
    # Only this client uses the server: a step must survive the end of the process, but not a power failure.
    # Clocks are off, so that an agent in a debugger does not time out.
    options = ("--no-fsync", "--workers", str(workers), "--step-seconds", "0", *more)
    data = data or default_data()
    if needs_episodes and not holds_episodes(data):
        check_installed(SERVER)
        notify(f"no episodes in {data} yet: generating a small part of {SPLIT} (only once)")
        make_episodes(data, quiet=quiet)
    return embedded_server(data, options=options, notify=notify)

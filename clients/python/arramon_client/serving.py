"""The server that a command is for: the one that it names, or one of its own on this machine's data."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from arramon_client.access import access_of, add_access
from arramon_client.connection import Server, connect
from arramon_client.embedded import default_data, embedded_server
from arramon_client.errors import UsageError


def add_server(parser: argparse.ArgumentParser) -> None:
    """Adds the options that `server_of` reads."""
    parser.add_argument("--server", metavar="ADDR", help="host:port or unix:/path (default: the runs on this machine)")
    parser.add_argument("--data", type=Path, metavar="DIR", help="of these runs ($ARRAMON_DATA, or ./arramon-data)")
    add_access(parser)


@contextmanager
def server_of(options: argparse.Namespace) -> Iterator[Server]:
    """The server, until the end of the context.

    Raises:
        UsageError: for both a server and a data folder.
        ArramonClientError: as `embedded_server` and `connect`.
    """
    if options.server is not None:
        if options.data is not None:
            raise UsageError("--data is for the runs on this machine, and cannot be used together with --server")
        with connect(options.server, access_of(options)) as server:
            yield server
        return
    with embedded_server(options.data or default_data(), notify=_say) as embedded, connect(embedded.address) as server:
        yield server


def _say(text: str) -> None:
    sys.stderr.write(f"{text}\n")

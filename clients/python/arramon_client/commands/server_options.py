"""Options that choose a command's server: a remote one, or an embedded one with a data folder of this machine."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from arramon_client.errors import UsageError
from arramon_client.local.embedded import default_data, embedded_server
from arramon_client.transport.access import access_of, add_access
from arramon_client.transport.connection import Server, connect


def add_server(parser: argparse.ArgumentParser) -> None:
    """Add the options that `server_of` reads."""
    parser.add_argument("--server", metavar="ADDR", help="host:port or unix:/path (default: runs on this machine)")
    parser.add_argument(
        "--data", type=Path, metavar="DIR", help="their data folder (default: $ARRAMON_DATA, or ./arramon-data)"
    )
    add_access(parser)


@contextmanager
def server_of(options: argparse.Namespace) -> Iterator[Server]:
    """Connect to the server, or start an embedded one, until the end of the context.

    Raises:
        UsageError: if both a server and a data folder are given.
        ArramonClientError: as for `embedded_server` and `connect`.
    """
    if options.server is not None:
        if options.data is not None:
            raise UsageError("--data applies to runs on this machine, and cannot be used together with --server")
        with connect(options.server, access_of(options)) as server:
            yield server
        return
    with embedded_server(options.data or default_data(), notify=_say) as embedded, connect(embedded.address) as server:
        yield server


def _say(text: str) -> None:
    sys.stderr.write(f"{text}\n")

"""The command `arramon-client mcp`: let assistants and editors play by the Model Context Protocol."""

import argparse
import asyncio
import sys
from collections.abc import Sequence
from pathlib import Path

from arramon_client.arguments import positive
from arramon_client.commands.base import run
from arramon_client.errors import UsageError
from arramon_client.printable import one_line
from arramon_client.run_settings import ENCODINGS
from arramon_client.runs.options import PlayOptions, ServerOptions
from arramon_client.transport.access import add_access, make_access

PATIENCE = 45.0
"""Default number of seconds to wait for a server that is away: hosts give up calls after a minute."""


def main(argv: Sequence[str]) -> int:
    """Run `arramon-client mcp` and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="arramon-client mcp",
        allow_abbrev=False,
        description="Serve ArraMon to an assistant or editor by the Model Context Protocol: over standard input and "
        "output or, with --http, over streamable HTTP on this machine.",
    )
    add = parser.add_argument
    add("--server", metavar="ADDR", help="host:port or unix:/path (default: runs on this machine)")
    add("--data", type=Path, metavar="DIR", help="their data folder (default: $ARRAMON_DATA, or ./arramon-data)")
    add("--http", metavar="HOST:PORT", help="serve HTTP on this address of this machine; port 0 for a free one")
    add("--allow-host", action="append", default=[], metavar="H", help="accept this Host header, too, for a proxy")
    add("--allow-origin", action="append", default=[], metavar="O", help="accept requests from this web origin, too")
    add("--parallel", type=positive, metavar="N", default=1, help="open at most N episodes of a run (default: 1)")
    add("--image-size", type=positive, metavar="N", help="size at which the server renders (default: its own)")
    add("--encoding", choices=ENCODINGS, help="encoding of images on the way from the server")
    add_access(parser)
    return run(parser, argv, _serve)


def _serve(options: argparse.Namespace) -> None:
    if options.server is not None and options.data is not None:
        raise UsageError("--data applies to runs on this machine, and cannot be used together with --server")
    if options.http is None and (options.allow_host or options.allow_origin):
        raise UsageError("--allow-host and --allow-origin apply to --http")
    try:
        from arramon_client.mcp import serving
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("arramon"):
            raise
        raise UsageError(f"this command needs {error.name}: pip install 'arramon-client[mcp]'") from error
    backend = ServerOptions(
        server=options.server, data=options.data, tls=options.tls, tls_ca=options.tls_ca, notify=_say
    )
    if options.server is not None:
        access = make_access(options.token, options.token_file, tls=options.tls, tls_ca=options.tls_ca)
        backend["token"] = access.token or None
    play = PlayOptions(encoding=options.encoding, image_size=options.image_size, patience=PATIENCE)
    http, hosts, origins = options.http, options.allow_host, options.allow_origin
    asyncio.run(serving.serve(backend, play, options.parallel, http, hosts, origins))


def _say(text: str) -> None:
    sys.stderr.write(f"{one_line(text)}\n")
    sys.stderr.flush()

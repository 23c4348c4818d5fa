"""Assembly of the MCP server from its parts."""

import sys
from collections.abc import Sequence

from arramon_client.mcp.backend import RunServer
from arramon_client.mcp.open_runs import OpenRuns
from arramon_client.mcp.server import make_server
from arramon_client.mcp.tools import Tools
from arramon_client.mcp.transports import serve_http, serve_stdio
from arramon_client.runs.options import PlayOptions, ServerOptions


async def serve(
    backend: ServerOptions,
    options: PlayOptions,
    parallel: int,
    http: str | None,
    hosts: Sequence[str],
    origins: Sequence[str],
) -> None:
    """Serve until the client goes or a signal arrives; then close all runs, which can be resumed.

    Args:
        backend: the server of all runs.
        options: how they are played.
        parallel: largest number of open episodes of a run.
        http: address for HTTP; None for standard input and output.
        hosts, origins: further values of `Host` and `Origin` to accept.

    Raises:
        UsageError: if the address cannot be used.
    """
    runs = OpenRuns(RunServer(backend), options, parallel)
    server = make_server(Tools(runs))
    try:
        if http is None:
            await serve_stdio(server, runs.close)
        else:
            await serve_http(server, http, hosts, origins, _announce)
    finally:
        await runs.close()


def _announce(url: str) -> None:
    sys.stdout.write(f"listening on {url}\n")
    sys.stdout.flush()

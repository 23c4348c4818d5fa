"""The tools of a process, on a scripted server or on a real one."""

from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager

import pytest
from mcp import Client

from arramon_client.mcp.backend import RunServer
from arramon_client.mcp.open_runs import OpenRuns
from arramon_client.mcp.server import make_server
from arramon_client.mcp.tools import Tools
from arramon_client.runs.options import PlayOptions, ServerOptions
from tests.client.fake import Servicer, World, serving

Connect = Callable[..., AbstractAsyncContextManager[Client]]


@asynccontextmanager
async def tools_on(
    address: str, mode: str = "auto", parallel: int = 1, patience: float = 10.0, token: str | None = None
) -> AsyncIterator[Client]:
    """Connect to a new process of the tools, as it were, on a server."""
    backend = RunServer(ServerOptions(server=address, notify=lambda _: None, token=token))
    runs = OpenRuns(backend, PlayOptions(patience=patience), parallel)
    try:
        async with Client(make_server(Tools(runs)), mode=mode) as client:
            yield client
    finally:
        await runs.close()


@pytest.fixture
def connect(world: World) -> Iterator[Connect]:
    """Return `tools_on` for the scripted server."""
    with serving(Servicer(world)) as address:
        yield lambda *arguments, **more: tools_on(address, *arguments, **more)

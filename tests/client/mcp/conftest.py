"""The tools of a process, on a scripted server."""

from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager

import pytest
from mcp import Client

from arramon_client.mcp.backend import Backend
from arramon_client.mcp.open_runs import OpenRuns
from arramon_client.mcp.server import make_server
from arramon_client.mcp.tools import Tools
from arramon_client.runs.options import PlayOptions
from tests.client.fake import Servicer, World, serving

Connect = Callable[..., AbstractAsyncContextManager[Client]]


@pytest.fixture
def connect(world: World) -> Iterator[Connect]:
    """Return a function that connects to a new process of the tools, as it were, on the scripted server."""
    with serving(Servicer(world)) as address:

        @asynccontextmanager
        async def connected(mode: str = "auto", parallel: int = 1, patience: float = 10.0) -> AsyncIterator[Client]:
            options = PlayOptions(server=address, notify=lambda _: None, patience=patience)
            runs = OpenRuns(Backend(options), options, parallel)
            try:
                async with Client(make_server(Tools(runs)), mode=mode) as client:
                    yield client
            finally:
                await runs.close()

        yield connected

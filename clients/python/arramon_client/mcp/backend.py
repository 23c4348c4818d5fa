"""The server on which all runs are played: a remote one, or an embedded one that is started when it is first needed."""

import asyncio
import os
from contextlib import ExitStack
from pathlib import Path

from arramon_client.errors import EmbeddedServerError
from arramon_client.local.embedded import EmbeddedServer
from arramon_client.local.embedded_play import embedded_for_play
from arramon_client.runs.options import ServerOptions
from arramon_client.transport.access import VARIABLE

CHECK_SECONDS = 0.5
"""Time between checks whether an embedded server has died."""


class RunServer:
    """The server of all runs.

    Args:
        options: the server; without `server` an embedded one.
    """

    def __init__(self, options: ServerOptions) -> None:
        self._options = options
        self._stack = ExitStack()
        self._starting: asyncio.Task[EmbeddedServer] | None = None
        self._watching: asyncio.Task[None] | None = None

    async def options(self) -> ServerOptions:
        """Return options that name a running server.

        Raises:
            EmbeddedServerError: if an embedded server does not start.
        """
        if self._options.get("server") is not None:
            return self._options
        if self._starting is None:
            self._starting = asyncio.create_task(asyncio.to_thread(self._start))
        try:
            embedded = await asyncio.shield(self._starting)  # A call that is cancelled does not stop it.
        except EmbeddedServerError:
            self._starting = None
            raise
        if self._watching is None:
            self._watching = asyncio.create_task(self._watch(embedded))
        return {"server": embedded.address, "notify": self._options["notify"]}

    async def close(self) -> None:
        """Stop an embedded server."""
        if self._watching is not None:
            self._watching.cancel()
        if self._starting is not None:
            await asyncio.wait([self._starting])
        await asyncio.to_thread(self._stack.close)

    def _start(self) -> EmbeddedServer:
        os.environ.pop(VARIABLE, None)  # It is for a remote server; this one has no accounts.
        data = self._options.get("data")
        return self._stack.enter_context(
            embedded_for_play(None if data is None else Path(data), self._options["notify"], quiet=True)
        )

    async def _watch(self, embedded: EmbeddedServer) -> None:
        """Restart the server when it has died; its runs reconnect."""
        while True:
            await asyncio.sleep(CHECK_SECONDS)
            try:
                await asyncio.to_thread(embedded.revive)
            except EmbeddedServerError as error:
                self._options["notify"](str(error))

"""Counts the streams that are open, whatever becomes of them: a participant's limit holds over all processes."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from server.errors import StorageError
from server.runs.callers import Caller
from server.runs.quotas import Quotas
from server.runs.records import Run

AGAIN_SECONDS = 1.0
"""Until a stream that could not be counted out, as the database was away, is tried again."""

_log = logging.getLogger(__name__)


class Counting:
    """Counts the streams of one process.

    Args:
        quotas: where all processes count.
        worker: this process, as the journal knows it.
    """

    def __init__(self, quotas: Quotas, worker: str) -> None:
        self._quotas = quotas
        self._worker = worker
        self._closing: set[asyncio.Task[None]] = set()

    @asynccontextmanager
    async def counted(self, caller: Caller, run: Run, player: str) -> AsyncIterator[None]:
        """Counts a stream in, and out at its end.

        Raises:
            OverQuota: if there are as many as may be.
            StorageError: if it cannot be counted now.
        """
        opening = asyncio.ensure_future(asyncio.to_thread(self._quotas.open_stream, caller, run, player, self._worker))
        try:
            await asyncio.shield(opening)
            yield
        finally:  # on its own: the call may be cancelled, and its end is not to wait for the database
            closing = asyncio.create_task(self._close(opening))
            self._closing.add(closing)
            closing.add_done_callback(self._closing.discard)

    async def _close(self, opening: "asyncio.Future[str]") -> None:
        (stream_id,) = await asyncio.gather(opening, return_exceptions=True)
        while isinstance(stream_id, str):
            try:
                await asyncio.to_thread(self._quotas.close_stream, stream_id)
                return
            except StorageError as error:
                _log.warning("a stream cannot be counted out yet: %s", error)
                await asyncio.sleep(AGAIN_SECONDS)

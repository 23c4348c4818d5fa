"""Enforcement of a participant's limit of open streams, across all server processes."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from arramon_server.errors import StorageError
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.accounts.quotas import Quotas
from arramon_server.runs.storage.records import Run

RETRY_SECONDS = 1.0
"""Delay before retrying to record a stream's end, if the database could not be reached."""

_log = logging.getLogger(__name__)


class StreamLimits:
    """Counts the open streams of one process.

    Args:
        quotas: storage of the counts of all processes.
        worker: id of this process in the journal.
    """

    def __init__(self, quotas: Quotas, worker: str) -> None:
        self._quotas = quotas
        self._worker = worker
        self._closing: set[asyncio.Task[None]] = set()

    @asynccontextmanager
    async def count(self, caller: Caller, run: Run, player: str) -> AsyncIterator[None]:
        """Count a stream as open while the block runs.

        Raises:
            OverQuota: if the participant has reached its limit of open streams.
            StorageError: if the database cannot be reached.
        """
        opening = asyncio.ensure_future(asyncio.to_thread(self._quotas.open_stream, caller, run, player, self._worker))
        try:
            await asyncio.shield(opening)
            yield
        finally:  # In a task of its own: the call may be cancelled, and its end must not wait for the database.
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
                _log.warning("cannot record the end of a stream yet: %s", error)
                await asyncio.sleep(RETRY_SECONDS)

"""Readiness of a server process: it is not draining, its database answers, and its engine runs."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable

from arramon_server.errors import ArraMonError

CHECK_SECONDS = 1.0
"""Interval between checks, in seconds."""

ANSWER_SECONDS = 5.0
"""Time within which the database must answer, in seconds."""

STUCK_SECONDS = 10.0
"""Time without a round after which the engine counts as stuck, in seconds; an idle engine makes one each second."""

NO_DATABASE = "the database cannot be used"
"""The only text that probes receive, as anybody may call them; the error, with hosts and paths, is logged."""

DRAINING = "the server is draining"

_log = logging.getLogger(__name__)


class Readiness:
    """Checks every second whether the process is ready, and reports changes.

    Args:
        query: queries the database; called in a thread, off the event loop.
        latest_round: returns the time of the engine's latest round, by `time.monotonic`.
        report: called whenever readiness changes, with whether the process is ready.
    """

    def __init__(
        self, query: Callable[[], object], latest_round: Callable[[], float], report: Callable[[bool], Awaitable[None]]
    ) -> None:
        self._query = query
        self._latest_round = latest_round
        self._report = report
        self._draining = False
        self._pending_query: asyncio.Future[object] | None = None
        self.problem = "the server is starting"
        """Why the process is not ready; empty if it is."""

    async def watch(self) -> None:
        """Check each second until cancelled."""
        while True:
            await self.check()
            await asyncio.sleep(CHECK_SECONDS)

    async def check(self) -> None:
        """Check once."""
        problem = self._stuck() or await self._database()
        await self._change(DRAINING if self._draining else problem)

    async def drain(self) -> None:
        """Mark the process as not ready, permanently."""
        self._draining = True
        await self._change(DRAINING)

    async def _change(self, problem: str) -> None:
        before, self.problem = self.problem, problem
        if problem and problem != before:
            _log.log(logging.INFO if self._draining else logging.ERROR, "not ready: %s", problem)
        elif before and not problem:
            _log.info("ready")
        if bool(before) != bool(problem):
            await self._report(not problem)

    def _stuck(self) -> str:
        seconds = time.monotonic() - self._latest_round()
        return f"the engine has been stuck for {seconds:.0f} seconds" if seconds > STUCK_SECONDS else ""

    async def _database(self) -> str:
        if self._pending_query is None:
            self._pending_query = asyncio.ensure_future(asyncio.to_thread(self._query))
        try:  # A query that hangs is awaited again, not started a second time.
            async with asyncio.timeout(ANSWER_SECONDS):  # not `wait_for`, which may swallow a cancellation of `watch`
                await asyncio.shield(self._pending_query)
        except ArraMonError as error:
            self._pending_query = None
            if self.problem != NO_DATABASE:
                _log.error("%s", error)
            return NO_DATABASE
        except TimeoutError:
            return f"the database has not answered for {ANSWER_SECONDS:.0f} seconds"
        self._pending_query = None
        return ""

"""Whether this process takes calls: it does not drain, its database answers, and its engine turns."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable

from server.errors import ArraMonError

LOOK_SECONDS = 1.0
"""Between two looks."""

ANSWER_SECONDS = 5.0
"""In which the database has to answer."""

TURN_SECONDS = 10.0
"""After so long without a turn the engine counts as stuck; idle, it turns each second."""

NO_DATABASE = "the database cannot be used"
"""All that probes are told, which strangers may reach: its own words name hosts and paths. They are in the log."""

_log = logging.getLogger(__name__)


class Readiness:
    """Looks each second, and tells of every change.

    Args:
        ask: asks the database anything; not called on the event loop.
        turned: when the engine last turned, by `time.monotonic`.
        tell: told whether the process is ready, each time that this changes.
    """

    def __init__(
        self, ask: Callable[[], object], turned: Callable[[], float], tell: Callable[[bool], Awaitable[None]]
    ) -> None:
        self._ask = ask
        self._turned = turned
        self._tell = tell
        self._draining = False
        self._asking: asyncio.Future[object] | None = None
        self.problem = "the server starts"
        """Why the process is not ready; empty where it is."""

    async def watch(self) -> None:
        """Looks until it is cancelled."""
        while True:
            await self.look()
            await asyncio.sleep(LOOK_SECONDS)

    async def look(self) -> None:
        """Looks once."""
        problem = self._stuck() or await self._database()
        await self._change("the server drains" if self._draining else problem)

    async def drain(self) -> None:
        """From now on the process is not ready any more."""
        self._draining = True
        await self._change("the server drains")

    async def _change(self, problem: str) -> None:
        before, self.problem = self.problem, problem
        if problem and problem != before:
            _log.log(logging.INFO if self._draining else logging.ERROR, "not ready: %s", problem)
        elif before and not problem:
            _log.info("ready")
        if bool(before) != bool(problem):
            await self._tell(not problem)

    def _stuck(self) -> str:
        silence = time.monotonic() - self._turned()
        return f"the engine has not turned for {silence:.0f} seconds" if silence > TURN_SECONDS else ""

    async def _database(self) -> str:
        if self._asking is None:
            self._asking = asyncio.ensure_future(asyncio.to_thread(self._ask))
        try:  # a question that hangs is not asked a second time beside the first
            async with asyncio.timeout(ANSWER_SECONDS):  # not `wait_for`, which may swallow the end of `watch`
                await asyncio.shield(self._asking)
        except ArraMonError as error:
            self._asking = None
            if self.problem != NO_DATABASE:
                _log.error("%s", error)
            return NO_DATABASE
        except TimeoutError:
            return f"the database has not answered for {ANSWER_SECONDS:.0f} seconds"
        self._asking = None
        return ""

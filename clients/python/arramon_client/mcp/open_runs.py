"""Runs that this process plays, by id: created here, or resumed when a call names them."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import TypeVar

from arramon_client.errors import (
    ArramonClientError,
    EpisodeLostError,
    ReceiptError,
    RunClosedError,
    StepAheadError,
    StepSpentError,
    UsageError,
)
from arramon_client.mcp.backend import RunServer
from arramon_client.runs.async_run import AsyncRun, AsyncRunEpisode
from arramon_client.runs.info import RunInfo
from arramon_client.runs.options import CreateOptions, PlayOptions

Result = TypeVar("Result")

MAX_OPEN = 16
"""Maximum number of runs that are kept open; beyond it the one that was used longest ago is closed, resumably."""

MAX_ENDED = 4
"""Number of ended episodes of a run that are kept, so that their last acts can be repeated."""

OFFER_SECONDS = 20.0
"""Longest wait for the server to offer an episode."""

ATTEMPTS = 3
"""How often a call is tried when another program takes its episode over."""

CALL_ERRORS = (UsageError, StepSpentError, ReceiptError)
"""Errors of a call, after which the run goes on."""


class OpenRun:
    """A run that is being played, with the episodes that the server has offered."""

    def __init__(self, run: AsyncRun, parallel: int) -> None:
        self.run = run
        self._parallel = parallel
        self._episodes: dict[str, AsyncRunEpisode] = {}
        self._changed = asyncio.Condition()
        self._error: ArramonClientError | None = None
        self._is_collected = False  # Whether no further episode will be offered.
        self._collecting = asyncio.create_task(self._collect())
        self._plans: dict[str, tuple[int, list[int], str]] = {}  # By episode: step, actions, and why they stopped.

    @property
    def is_over(self) -> bool:
        """Whether all episodes have ended."""
        return self.run.info.is_over

    @property
    def open_episodes(self) -> list[AsyncRunEpisode]:
        """Open episodes of this process."""
        return [episode for episode in self._episodes.values() if not episode.ended]

    async def episode(self, episode_id: str) -> AsyncRunEpisode | None:
        """Return an episode, waiting until the server has offered all that can be open; None if it is not among them.

        Raises:
            ArramonClientError: if the connection was lost for too long.
        """

        def is_known() -> bool:
            info = self.run.info
            expected = min(self._parallel, info.episodes - info.ended)
            return episode_id in self._episodes or len(self.open_episodes) >= expected

        await self._wait(is_known)
        return self._episodes.get(episode_id)

    async def any_episode(self) -> AsyncRunEpisode | None:
        """Return the open episode that was offered first; None if the run is over, or no episode was offered in time.

        Raises:
            ArramonClientError: if the connection was lost for too long.
        """
        await self._wait(lambda: bool(self.open_episodes))
        return next(iter(self.open_episodes), None)

    def plan_stopped(self, episode_id: str, step: int, actions: list[int], reason: str) -> str:
        """Return why a plan stopped, also if the same plan is sent again.

        Args:
            episode_id, step, actions: the plan.
            reason: why it stopped now; empty if it did not, or took no step, as it is repeated.
        """
        latest = self._plans.get(episode_id)
        if not reason and latest is not None and latest[:2] == (step, actions):
            return latest[2]
        self._plans[episode_id] = (step, actions, reason)
        return reason

    async def close(self) -> None:
        """Close the run; it can be resumed."""
        await self.run.close()
        await asyncio.wait([self._collecting])

    async def _collect(self) -> None:
        try:
            async for episode in self.run.episodes():
                self._episodes.pop(episode.episode_id, None)  # Offered again: it is the latest.
                self._episodes[episode.episode_id] = episode
                self._forget_ended()
                await self._announce()
        except ArramonClientError as error:
            self._error = error
        finally:
            self._is_collected = True
            await self._announce()

    def _forget_ended(self) -> None:
        ended = [episode.episode_id for episode in self._episodes.values() if episode.ended]
        for episode_id in ended[:-MAX_ENDED]:
            del self._episodes[episode_id]
            self._plans.pop(episode_id, None)

    async def _announce(self) -> None:
        async with self._changed:
            self._changed.notify_all()

    async def _wait(self, is_there: Callable[[], bool]) -> None:
        """Wait until a condition holds, the run is over, or OFFER_SECONDS have passed."""
        async with self._changed:
            try:
                await asyncio.wait_for(self._changed.wait_for(lambda: self._is_collected or is_there()), OFFER_SECONDS)
            except TimeoutError:
                return
        if self._error is not None and not is_there():
            raise self._error


class OpenRuns:
    """All runs that this process plays.

    Args:
        backend: their server.
        options: how they are played, without the server.
        parallel: largest number of open episodes of a run.
    """

    def __init__(self, backend: RunServer, options: PlayOptions, parallel: int) -> None:
        self._backend, self._options, self._parallel = backend, options, parallel
        self._open: dict[str, OpenRun] = {}
        self._opening: dict[str, asyncio.Task[OpenRun]] = {}

    async def create(self, language: str, agent: str, options: CreateOptions) -> OpenRun:
        """Create a run; errors as for `AsyncRun.create`."""
        server = await self._backend.options()
        every: CreateOptions = {**self._options, **server, **options, "parallel": self._parallel}
        return await self._keep(await AsyncRun.create(language=language, agent=agent, **every))

    async def listed(self) -> list[RunInfo]:
        """Return the caller's runs, the latest first; errors as for `AsyncRun.list`."""
        return await AsyncRun.list(**await self._backend.options())

    async def use(self, run_id: str, work: Callable[[OpenRun], Awaitable[Result]]) -> Result:
        """Call a function with a run, resuming the run if this process does not play it.

        If another program has taken over an episode of the run, the run is resumed, and the function is called again.

        Raises:
            ArramonClientError: if there is no such run, or the server refuses or cannot be reached.
        """
        for attempt in range(ATTEMPTS):
            opened = await self._opened(run_id)
            try:
                return await work(opened)
            except CALL_ERRORS:
                raise
            except StepAheadError:
                if attempt > 0:
                    raise
                await self._drop(opened)  # Another program may have gone on meanwhile: ask the server.
            except (EpisodeLostError, RunClosedError):
                await self._drop(opened)
                if attempt == ATTEMPTS - 1:
                    raise
            except ArramonClientError:
                await self._drop(opened)
                raise
        raise AssertionError

    async def close(self) -> None:
        """Close all runs; they can be resumed."""
        for task in list(self._opening.values()):
            task.cancel()
        await asyncio.gather(*(opened.close() for opened in self._open.values()))
        self._open.clear()
        await self._backend.close()

    async def _opened(self, run_id: str) -> OpenRun:
        opened = self._open.pop(run_id, None)
        if opened is not None:
            self._open[run_id] = opened  # The latest is the last.
            return opened
        task = self._opening.get(run_id)
        if task is None:
            task = self._opening[run_id] = asyncio.create_task(self._resume(run_id))
            task.add_done_callback(lambda _: self._opening.pop(run_id, None))
        return await asyncio.shield(task)  # A call that is cancelled does not stop others.

    async def _resume(self, run_id: str) -> OpenRun:
        server = await self._backend.options()
        every: PlayOptions = {**self._options, **server, "parallel": self._parallel}
        return await self._keep(await AsyncRun.resume(run_id, **every))

    async def _keep(self, run: AsyncRun) -> OpenRun:
        opened = self._open[run.run_id] = OpenRun(run, self._parallel)
        while len(self._open) > MAX_OPEN:
            await self._drop(next(iter(self._open.values())))
        return opened

    async def _drop(self, opened: OpenRun) -> None:
        if self._open.get(opened.run.run_id) is opened:
            del self._open[opened.run.run_id]
        await opened.close()

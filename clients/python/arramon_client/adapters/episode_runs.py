"""Episodes played one by one in an event loop, each in a run of its own."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

from arramon_client.adapters.host import Host
from arramon_client.adapters.results import episode_result, unfinished_result
from arramon_client.errors import UsageError
from arramon_client.runs.async_run import AsyncRun, AsyncRunEpisode


class EpisodeRuns:
    """Runs of single episodes, whose scores are known when the episode has ended.

    A hidden split can only be played whole: its episodes are those of one run, in the run's order, and the scores of
    the run are known when the last one has ended.

    Args:
        host: the server.
        parallel: largest number of episodes of a hidden split that are open at once.
    """

    def __init__(self, host: Host, parallel: int = 1) -> None:
        self._host, self._parallel = host, parallel
        self._lock = asyncio.Lock()
        self._whole: AsyncRun | None = None
        self._rest: AsyncIterator[AsyncRunEpisode] | None = None

    async def open(self, episode_id: str) -> "AdapterEpisode":
        """Begin an episode.

        Args:
            episode_id: id of the episode; on a hidden split it only names the result.

        Raises:
            UsageError: if all episodes of a hidden split have been handed out.
            ArramonClientError: if the server refuses, or does not answer.
        """
        host = self._host
        if not host.is_hidden:
            run = await AsyncRun.create(
                language=host.language, agent=host.agent, **host.run_options(episode_id) | {"parallel": 1}
            )
            return AdapterEpisode(run, await anext(run.episodes()), owns_run=True)
        async with self._lock:
            if self._whole is None:
                options = host.run_options(None) | {"parallel": self._parallel}
                self._whole = await AsyncRun.create(language=host.language, agent=host.agent, **options)
                self._rest = self._whole.episodes()
            assert self._rest is not None
            episode = await anext(self._rest, None)
        if episode is None:
            raise UsageError(f"the hidden split {host.split!r} has no more episodes in this run")
        return AdapterEpisode(self._whole, episode, owns_run=False)


class AdapterEpisode:
    """An episode that is being played.

    Attributes:
        episode: the episode.
    """

    def __init__(self, run: AsyncRun, episode: AsyncRunEpisode, *, owns_run: bool) -> None:
        self.episode = episode
        self._run, self._owns_run = run, owns_run

    async def finish(self, reason: str = "the adapter stopped before the episode's end") -> dict[str, Any]:
        """End the episode, giving it up if necessary, and return its result (see `episode_result`).

        On a hidden split the result has the run's scores and receipt only if no other episode is left.
        """
        run, episode = self._run, self.episode
        try:
            if not episode.ended:
                await episode.give_up(reason)
            if not self._owns_run and run.info.ended < run.info.episodes:
                return unfinished_result(run.info, episode.episode_id, episode.cause)
            await run.wait()
            return episode_result(
                episode.episode_id, episode.cause, await episode.scores(), await run.report(), await run.receipt()
            )
        finally:
            if self._owns_run or run.info.is_over:
                await run.close()

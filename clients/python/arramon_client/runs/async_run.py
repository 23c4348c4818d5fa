"""A run that is played step by step in an event loop, several episodes at once."""

import asyncio
import builtins
from collections.abc import AsyncIterator, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Unpack

from arramon_client.agent import Episode, Observation
from arramon_client.runs import opening
from arramon_client.runs.info import RunInfo
from arramon_client.runs.live_episode import LiveEpisode
from arramon_client.runs.opening import OpenedRun
from arramon_client.runs.options import CreateOptions, PlayOptions, ServerOptions
from arramon_client.runs.results import info_now, report_data, scores_of
from arramon_client.runs.waiting import wait_async

if TYPE_CHECKING:
    from arramon_client.agent import Note
    from arramon_client.receipts import Receipt

PARALLEL = 8
"""Default number of open episodes."""


class AsyncRun:
    """A run like `Run`, whose methods are awaited; an asynchronous context manager that closes it.

    Several episodes can be played at once, each at its own pace:

        async def play(episode):
            while not episode.ended:
                seen = await episode.look()
                await episode.act(seen.step, await choose_action(seen))

        async with await AsyncRun.create(language="en", agent="my-model", split="val_seen") as run:
            async with asyncio.TaskGroup() as tasks:
                async for episode in run.episodes():
                    tasks.create_task(play(episode))

    The methods may be called in any event loop, and work as those of `Run`, which documents them. Cancelling a call
    leaves the run as it is: an act that was sent is taken, and repeating the call returns what follows.
    """

    def __init__(self, opened: OpenedRun) -> None:
        self._opened = opened

    @classmethod
    async def create(cls, *, language: str, agent: str, **options: Unpack[CreateOptions]) -> "AsyncRun":
        """Create a run, and open its first episodes; arguments and errors as for `Run.create`."""
        return cls(await asyncio.to_thread(opening.create, language, agent, options, PARALLEL))

    @classmethod
    async def resume(cls, run_id: str, *, history: bool = False, **options: Unpack[PlayOptions]) -> "AsyncRun":
        """Resume a run; arguments and errors as for `Run.resume`."""
        return cls(await asyncio.to_thread(opening.resume, run_id, options, PARALLEL, history=history))

    @staticmethod
    async def list(**options: Unpack[ServerOptions]) -> builtins.list[RunInfo]:
        """Return the runs that the caller may see on a server; arguments and errors as for `Run.list`."""
        return await asyncio.to_thread(opening.list_runs, options)

    @property
    def run_id(self) -> str:
        """Id of the run."""
        return self._opened.run_id

    @property
    def info(self) -> RunInfo:
        """Description of the run, as of the latest message of the server; `ended` is always up to date."""
        return info_now(self._opened.live)

    async def episodes(self) -> "AsyncIterator[AsyncRunEpisode]":
        """Yield the run's episodes as the server offers them, until the run is over; see `Run.episodes`."""
        while (episode := await wait_async(self._opened.next_episode())) is not None:
            yield AsyncRunEpisode(self._opened, episode)

    async def wait(self) -> RunInfo:
        """Wait until the run is over, and return its description."""
        await wait_async(self._opened.live.end_of_run())
        return self.info

    async def report(self) -> dict[str, Any]:
        """Return the scores as plain data; see `Run.report`."""
        return report_data(await asyncio.to_thread(self._opened.report))

    async def receipt(self) -> "Receipt":
        """Return the run's signed receipt; see `Run.receipt`."""
        return await asyncio.to_thread(self._opened.receipt)

    async def cancel(self) -> None:
        """Cancel the run; see `Run.cancel`."""
        await asyncio.to_thread(self._opened.cancel)
        await self.wait()

    async def close(self) -> None:
        """Close the connection, and stop an embedded server. The run stays open, and can be resumed."""
        await asyncio.to_thread(self._opened.close)

    async def __aenter__(self) -> "AsyncRun":
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()


class AsyncRunEpisode:
    """An episode of an `AsyncRun`, like `RunEpisode`, which documents the methods."""

    def __init__(self, opened: OpenedRun, live: LiveEpisode) -> None:
        self._opened, self._live = opened, live

    def __repr__(self) -> str:
        return f"<AsyncRunEpisode {self.episode_id}: {self.cause or 'open'}>"

    @property
    def episode_id(self) -> str:
        """Id of the episode, unique within the split."""
        return self._live.episode_id

    @property
    def episode(self) -> Episode:
        """What an agent gets when an episode begins: language, split, labels of segmentations."""
        return self._live.episode

    @property
    def ended(self) -> bool:
        """Whether the episode has ended."""
        return bool(self._live.cause)

    @property
    def cause(self) -> str:
        """Why the episode ended; see `RunEpisode.cause`."""
        return self._live.cause

    @property
    def actions(self) -> tuple[int, ...]:
        """Actions recorded so far, from the first step on; the last one may not have been applied."""
        return self._live.recorded

    @property
    def stop_reason(self) -> str:
        """Why the latest plan stopped before its last action; see `RunEpisode.act`."""
        return self._live.stop_reason

    async def look(self) -> Observation:
        """Return the observation that awaits an action; see `RunEpisode.look`."""
        return await wait_async(self._live.look())

    async def act(self, step: int, actions: int | Sequence[int], note: "Note | None" = None) -> Observation | None:
        """Take a step or several, and return the next observation; see `RunEpisode.act`."""
        return await wait_async(self._live.act(step, actions, note))

    async def give_up(self, reason: str = "") -> None:
        """Give up the episode; see `RunEpisode.give_up`."""
        await wait_async(self._live.give_up(reason))

    async def scores(self) -> dict[str, dict[str, float]] | None:
        """Return the episode's scores; see `RunEpisode.scores`."""
        return scores_of(await asyncio.to_thread(self._opened.report), self.episode_id)

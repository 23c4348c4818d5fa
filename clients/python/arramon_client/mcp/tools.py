"""The tools: what each does with the participant's runs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from arramon_client.agent import Observation
from arramon_client.errors import UsageError
from arramon_client.mcp.arguments import (
    ActArguments,
    GiveUpArguments,
    LookArguments,
    ReportArguments,
    RunsArguments,
    StartArguments,
    ViewArguments,
)
from arramon_client.mcp.open_runs import OpenRun, OpenRuns
from arramon_client.mcp.pictures import chosen_images, picture
from arramon_client.mcp.views import (
    ActView,
    EpisodeView,
    PlayView,
    ReportView,
    RunsView,
    episode_view,
    run_view,
)
from arramon_client.runs.async_run import AsyncRunEpisode
from arramon_client.runs.live_episode import UNKNOWN
from arramon_client.runs.options import CreateOptions
from arramon_client.world import Action


@dataclass(frozen=True)
class EncodedPicture:
    """An image of a result.

    Attributes:
        content: the file.
        mime_type: "image/png" or "image/jpeg".
    """

    content: bytes
    mime_type: str


@dataclass(frozen=True)
class ToolResult:
    """The result of a tool: structured data, and images."""

    data: BaseModel
    pictures: Sequence[EncodedPicture] = ()


class Tools:
    """The tools; each takes its checked arguments.

    Errors are those of `Run` and `RunEpisode`: every ArramonClientError has a message for the caller.

    Args:
        runs: the participant's runs.
    """

    def __init__(self, runs: OpenRuns) -> None:
        self._runs = runs

    async def start(self, given: StartArguments) -> ToolResult:
        """Create a run."""
        options = CreateOptions(
            split=given.split,
            sensors=tuple(given.sensors),
            episodes=given.episodes,
            episode_ids=tuple(given.episode_ids),
            agent_arguments=given.agent_arguments,
        )
        opened = await self._runs.create(given.language, given.agent, options)
        return ToolResult(_play_view(PlayView, opened, None))

    async def runs(self, given: RunsArguments) -> ToolResult:
        """List the participant's runs."""
        found = [info for info in await self._runs.listed() if given.state in (None, info.state)]
        shown = found[: given.limit]
        return ToolResult(RunsView(runs=[run_view(info) for info in shown], more=len(found) - len(shown)))

    async def look(self, given: LookArguments) -> ToolResult:
        """Show the observation that awaits an action."""

        async def work(opened: OpenRun) -> ToolResult:
            if given.episode is not None:
                return await self._look_at(opened, given.episode, given)
            episode = await opened.any_episode()
            if episode is not None:
                return await self._shown(PlayView, opened, episode, await episode.look(), given)
            if opened.is_over:
                return ToolResult(_play_view(PlayView, opened, None))
            raise UsageError("the server has offered no episode of this run yet; call `look` again")

        return await self._runs.use(given.run, work)

    async def act(self, given: ActArguments) -> ToolResult:
        """Take one step or several, each once."""
        actions = [int(Action[name]) for name in given.actions]

        async def work(opened: OpenRun) -> ToolResult:
            chosen_images(given.images, opened.run.info.sensors)  # Fail before a step is taken.
            episode = await opened.episode(given.episode)
            if episode is None:
                view = await _missing(opened, given.episode)
                end = await _recorded_steps(opened, given.episode)  # This call may repeat one whose answer was lost.
                return ToolResult(_play_view(ActView, opened, view, taken=_taken(end, given), stopped=""))
            after = await episode.act(given.step, actions, given.note or None)
            reason = episode.stop_reason  # Before anything else is awaited: the next act resets it.
            stopped = opened.plan_stopped(episode.episode_id, given.step, actions, reason)
            end = len(episode.actions) if after is None else after.step
            taken = _taken(end, given)
            return await self._shown(ActView, opened, episode, after, given, taken=taken, stopped=stopped)

        return await self._runs.use(given.run, work)

    async def give_up(self, given: GiveUpArguments) -> ToolResult:
        """Give up an episode."""

        async def work(opened: OpenRun) -> ToolResult:
            episode = await opened.episode(given.episode)
            if episode is None:
                return ToolResult(_play_view(PlayView, opened, await _missing(opened, given.episode)))
            await episode.give_up(given.reason)
            return ToolResult(_play_view(PlayView, opened, _ended(episode)))

        return await self._runs.use(given.run, work)

    async def report(self, given: ReportArguments) -> ToolResult:
        """Show the scores of a run that is over."""

        async def work(opened: OpenRun) -> ToolResult:
            report = await opened.run.report()
            receipt = await opened.run.receipt()
            view = ReportView(
                run=run_view(opened.run.info),
                scores=report["metrics"],
                signature=report["signature"],
                receipt=receipt.digest.hex(),
                episodes=report["episodes"] if given.episodes else None,
            )
            return ToolResult(view)

        return await self._runs.use(given.run, work)

    async def _look_at(self, opened: OpenRun, episode_id: str, given: ViewArguments) -> ToolResult:
        episode = await opened.episode(episode_id)
        if episode is None:
            return ToolResult(_play_view(PlayView, opened, await _missing(opened, episode_id)))
        seen = None if episode.ended else await episode.look()
        return await self._shown(PlayView, opened, episode, seen, given)

    async def _shown(
        self,
        view: type[PlayView],
        opened: OpenRun,
        episode: AsyncRunEpisode,
        seen: Observation | None,
        given: ViewArguments,
        **more: Any,
    ) -> ToolResult:
        """Return an episode with its observation and images; with its end if there is no observation."""
        if seen is None or episode.ended:
            return ToolResult(_play_view(view, opened, _ended(episode), **more))
        names = chosen_images(given.images, opened.run.info.sensors)
        files = [picture(seen, name, given.image_format, given.image_size) for name in names]
        shown = episode_view(episode, seen, [f"{name} ({given.image_format})" for name in names])
        pictures = [EncodedPicture(file, f"image/{given.image_format}") for file in files]
        return ToolResult(_play_view(view, opened, shown, **more), pictures)


def _ended(episode: AsyncRunEpisode) -> EpisodeView:
    return EpisodeView(id=episode.episode_id, ended=True, cause=episode.cause)


async def _missing(opened: OpenRun, episode_id: str) -> EpisodeView:
    """Return the end of an episode that is not open, if the run is over and has it.

    Raises:
        UsageError: if the run is not over, or has no such episode.
    """
    if opened.is_over:
        report = await opened.run.report()
        causes = {episode["episode_id"]: episode.get("cause", UNKNOWN) for episode in report["episodes"]}
        if not causes:  # A hidden split does not disclose its episodes.
            return EpisodeView(id=episode_id, ended=True, cause=UNKNOWN)
        if episode_id in causes:
            return EpisodeView(id=episode_id, ended=True, cause=causes[episode_id])
        raise UsageError(f"run {opened.run.run_id} has no episode {episode_id!r}; it is over: call `report`")
    now = ", ".join(episode.episode_id for episode in opened.open_episodes) or "none"
    raise UsageError(
        f"episode {episode_id!r} of run {opened.run.run_id} is not open: it has ended, has not begun, or does not "
        f"exist. This call took no step. Open episodes: {now}. Call `look` with the run alone to go on"
    )


async def _recorded_steps(opened: OpenRun, episode_id: str) -> int:
    """Return the number of steps of an episode of a run that is over; 0 on a hidden split, which hides it."""
    report = await opened.run.report()
    return next((each["steps"] for each in report["episodes"] if each["episode_id"] == episode_id), 0)


def _taken(end: int, given: ActArguments) -> int:
    """Return how many actions of a call are recorded, if its episode has this number of steps."""
    return min(max(end - given.step, 0), len(given.actions))


def _play_view(view: type[PlayView], opened: OpenRun, episode: EpisodeView | None, **more: Any) -> PlayView:
    return view(
        run=run_view(opened.run.info),
        episode=episode,
        open_episodes=[each.episode_id for each in opened.open_episodes],
        next=_next(opened, episode),
        **more,
    )


def _next(opened: OpenRun, episode: EpisodeView | None) -> str:
    if episode is not None and not episode.ended:
        return f"call `act` with step {episode.step}"
    return "the run is over: call `report`" if opened.is_over else "call `look` with the run for the next episode"

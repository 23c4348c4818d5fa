"""Play with an agent that waits: each open episode in a task of its own, at its own pace."""

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace

from arramon.v1 import evaluation_pb2, evaluation_pb2_grpc
from arramon_client.agent import Answer, AsyncAgent, Observation
from arramon_client.errors import AgentError, AgentStoppedError, EpisodeLostError, StopRun
from arramon_client.notes import note_fault, note_text
from arramon_client.observations import nondeterminism_warning
from arramon_client.play_results import AgentFailure, Outcome, Progress
from arramon_client.plugin import agent_calls, async_calls
from arramon_client.recording.recorder import EpisodeRecorder
from arramon_client.runs.info import RunInfo
from arramon_client.runs.live import LiveRun
from arramon_client.runs.live_episode import LiveEpisode
from arramon_client.runs.results import info_now
from arramon_client.runs.waiting import wait_async
from arramon_client.settings import Settings

FIRST_DELAY, LAST_DELAY = 0.5, 8.0
"""Shortest and longest delay in seconds before `act` is called again after an exception; it doubles each time. An
invalid answer is asked for again at once."""


@dataclass(frozen=True)
class StreamTarget:
    """One stream of a run.

    Attributes:
        stub: stub of the server.
        address: its address, for messages.
        settings: settings of the stream.
    """

    stub: evaluation_pb2_grpc.EvaluationStub
    address: str
    settings: Settings


async def play_over(
    targets: Sequence[StreamTarget],
    run: evaluation_pb2.Run,
    agent: AsyncAgent,
    settings: Settings,
    *,
    notify: Callable[[str], None],
    progress: Callable[[Progress], None],
    revive: Callable[[], None],
    recording: EpisodeRecorder | None,
) -> Outcome:
    """Play a run to its end over one or several streams.

    Raises:
        StopRun: if the agent raises it; other calls of `act` are completed, and the run can be resumed.
        AgentStoppedError: if the agent fails and `settings` asks to stop; likewise.
        ArramonClientError: as for `play`.
    """
    live = LiveRun(run, replays=True, notify=notify)
    player = _AsyncPlayer(live, agent, settings, notify, progress, recording)
    async with _opened(agent, replace(info_now(live), output=settings.output), notify):
        for target in targets:
            live.start(target.stub, target.settings, target.address, revive)
        try:
            await player.play()
        finally:
            await asyncio.to_thread(live.close)
    players = live.players
    return Outcome(
        run=live.run,
        steps=live.steps,
        failures=tuple(player.failures),
        problems=tuple(problem for each in players for problem in each.problems),
        reconnections=live.reconnections,
        actions={episode_id: sent for each in players for episode_id, sent in each.actions.items()},
    )


@asynccontextmanager
async def _opened(agent: AsyncAgent, run: RunInfo, notify: Callable[[str], None]) -> AsyncIterator[None]:
    """Call the agent's `open`, and its `close` at the end of the context; a failure of that is only reported."""
    await async_calls.call_optional(agent, "open", run)
    try:
        yield
    finally:
        try:
            await async_calls.call_optional(agent, "close")
        except (AgentError, StopRun) as error:
            notify(f"the agent failed at the end of the run: {error}")


class _AsyncPlayer:
    """Plays the episodes of a run, each in a task of its own."""

    def __init__(
        self,
        live: LiveRun,
        agent: AsyncAgent,
        settings: Settings,
        notify: Callable[[str], None],
        progress: Callable[[Progress], None],
        recording: EpisodeRecorder | None,
    ) -> None:
        self.failures: list[AgentFailure] = []
        self._live, self._agent, self._settings = live, agent, settings
        self._notify, self._progress, self._recording = notify, progress, recording
        self._can_replay = agent_calls.can_replay(agent)
        self._stop: AgentStoppedError | StopRun | None = None
        self._stopping = asyncio.Event()
        self._begun: set[str] = set()  # Open episodes whose `begin` succeeded.
        self._tasks: dict[str, asyncio.Task[None]] = {}  # The latest task of each episode.
        self._warned = False

    async def play(self) -> None:
        """Play all episodes, or until the agent stops the run."""
        try:
            async with asyncio.TaskGroup() as tasks:
                while (episode := await self._next_episode()) is not None:
                    before = self._tasks.get(episode.episode_id)
                    self._tasks[episode.episode_id] = tasks.create_task(self._play(episode, before))
        except BaseExceptionGroup as group:
            raise group.exceptions[0] from None
        if self._stop is not None:
            raise self._stop

    async def _next_episode(self) -> LiveEpisode | None:
        """Return the next episode; None when the run is over or must stop."""
        coming = asyncio.ensure_future(wait_async(self._live.next_episode()))
        stopping = asyncio.ensure_future(self._stopping.wait())
        try:
            await asyncio.wait((coming, stopping), return_when=asyncio.FIRST_COMPLETED)
            return None if self._stopping.is_set() else await coming
        finally:
            coming.cancel()
            stopping.cancel()

    async def _play(self, episode: LiveEpisode, before: "asyncio.Task[None] | None") -> None:
        """Play an episode until it ends, another player takes it over, or the run must stop.

        Args:
            episode: the episode.
            before: task that played it on another stream, or before another player did, and must end first; or None.
        """
        if before is not None and not before.done():
            before.cancel()
            await asyncio.wait((before,))
        if self._recording is not None:
            self._recording.begin(episode.episode)
        try:
            if await self._begin(episode):
                while not self._stopping.is_set() and await self._step(episode):
                    self._progress(self._state())
        except EpisodeLostError:
            pass
        except asyncio.CancelledError:
            if not episode.cause and not episode.lost:  # By the agent: its episode would stand still.
                reason = f"run stopped: the task of episode {episode.episode_id} was cancelled"
                self._stop_run(AgentStoppedError(reason))
            raise
        finally:
            if self._recording is not None and episode.cause_code is not None:
                self._recording.end(episode.episode_id, episode.cause_code)
            if episode.episode_id in self._begun and (episode.cause or episode.lost):
                await self._end(episode)

    async def _begin(self, episode: LiveEpisode) -> bool:
        """Call the agent's `begin`; return whether it succeeded."""
        try:
            await async_calls.begin(self._agent, episode.episode)
        except StopRun as stop:
            self._stop_run(stop)
            return False
        except AgentError as error:
            await self._fail(episode, None, error)
            return False
        self._begun.add(episode.episode_id)
        return True

    async def _step(self, episode: LiveEpisode) -> bool:
        """Answer the present observation, and wait until the answer is recorded; return False at the episode's end."""
        seen = await wait_async(episode.present())
        if seen is None:
            return False
        answer = await self._ask(episode, seen)
        if answer is None:
            return False
        if seen.taken is not None:
            self._compare(seen, answer.action)
            answer = Answer(seen.taken)
        if self._recording is not None:
            self._recording.step(seen, answer.action)
        await wait_async(episode.act(seen.step, answer.action, self._note(answer)))
        return not episode.cause

    async def _ask(self, episode: LiveEpisode, seen: Observation) -> Answer | None:
        """Return the agent's answer, asking again after a failure; None if the episode is over for it."""
        is_replayed = seen.taken is not None and self._can_replay
        retries = 0 if is_replayed else self._settings.retries  # A repeated `replay` would count a step twice.
        for attempt in range(retries + 1):
            if attempt and self._stopping.is_set():
                return None
            try:
                if is_replayed:
                    return await async_calls.replay(self._agent, seen)
                return await async_calls.act(self._agent, seen)
            except StopRun as stop:
                self._stop_run(stop)
                return None
            except AgentError as error:
                failure = error
                if attempt < retries:
                    if not attempt:
                        where = f"step {seen.step} of episode {seen.episode_id}"
                        self._notify(f"the agent failed at {where}, and is asked again: {error}")
                    if isinstance(error, async_calls.AgentRaisedError):
                        await asyncio.sleep(min(FIRST_DELAY * 2**attempt, LAST_DELAY))
        await self._fail(episode, seen, failure)
        return None

    async def _fail(self, episode: LiveEpisode, seen: Observation | None, error: AgentError) -> None:
        """Give up an episode in which the agent failed, or stop the run."""
        where = f"{f'at step {seen.step}' if seen is not None else 'at the start'} of episode {episode.episode_id}"
        if self._recording is not None and seen is not None:
            self._recording.step(seen, None)
        if not self._settings.gives_up:
            self._stop_run(AgentStoppedError(f"run stopped: the agent failed {where}: {error}", error.details))
            return
        if not self.failures:
            self._notify(f"the agent failed {where}, which is given up: {error}")
        self.failures.append(AgentFailure((episode.episode_id,), str(error), error.details))
        await wait_async(episode.give_up(str(error)))

    async def _end(self, episode: LiveEpisode) -> None:
        """Call the agent's `end` for an episode that has ended or was taken over."""
        self._begun.discard(episode.episode_id)
        try:
            await async_calls.call_optional(self._agent, "end", episode.episode_id)
        except StopRun as stop:
            self._stop_run(stop)
        except AgentError as error:
            if not self._settings.gives_up:
                self._stop_run(AgentStoppedError(f"run stopped: the agent failed: {error}", error.details))
                return
            if not self.failures:
                self._notify(f"the agent failed, but no episode is given up: {error}")
            self.failures.append(AgentFailure((), str(error), error.details))

    def _stop_run(self, reason: AgentStoppedError | StopRun) -> None:
        self._stop = self._stop or reason
        self._stopping.set()

    def _note(self, answer: Answer) -> str:
        text = note_text(answer.note)
        fault = note_fault(text)
        if fault:
            with self._live.lock:
                self._live.players[0].refuse_note(f"the agent's note was not stored: {fault}")
        return "" if fault else text

    def _compare(self, seen: Observation, action: int) -> None:
        if action != seen.taken and not self._warned:
            self._warned = True
            self._notify(nondeterminism_warning(seen, action))

    def _state(self) -> Progress:
        live = self._live
        return Progress(live.run.episodes, live.episodes_ended, live.steps)

"""The benchmark as a task of Inspect: `inspect eval arramon_client/arramon -T lang=hi -T server=HOST:PORT`.

A sample is an episode, played with the tools `look` and `act`; the score is the server's.
"""

from typing import Any

from arramon_client.adapters.episode_runs import EpisodeRuns
from arramon_client.adapters.extras import extra
from arramon_client.adapters.host import Host
from arramon_client.adapters.model_view import RULES, actions_of, observation_text, picture_url
from arramon_client.adapters.results import METRICS, headline
from arramon_client.agent import Observation
from arramon_client.errors import StepAheadError, StepSpentError, UsageError
from arramon_client.runs.async_run import AsyncRunEpisode

with extra("inspect"):
    import anyio
    from inspect_ai import Task, task
    from inspect_ai.dataset import MemoryDataset, Sample
    from inspect_ai.model import ChatMessageSystem, ChatMessageUser, ContentImage, ContentText
    from inspect_ai.scorer import Metric, Score, Scorer, Target, mean, scorer, stderr
    from inspect_ai.solver import Generate, Solver, TaskState, solver
    from inspect_ai.tool import Tool, ToolError, tool

RESULT = "arramon"
"""Key of an episode's result in the sample's store."""

CALL_A_TOOL = "Call the tool act to go on."

MAX_SILENT = 3
"""Number of answers in a row without a tool call after which the episode is given up."""

Content = list[Any]
"""Text and image content of a message."""


@task
def arramon(
    lang: str = "en",
    split: str | None = None,
    server: str | None = None,
    data: str | None = None,
    episodes: int = 0,
    agent: str = "inspect",
    image_size: int | None = None,
) -> Task:
    """Return the task.

    Args:
        lang: language of the instructions.
        split: name of the split; None for the server's only one with the language.
        server: address of the server, HOST:PORT; None for an embedded one. The token is that of `$ARRAMON_TOKEN`.
        data: data folder of the embedded server.
        episodes: number of episodes, from the start of the split's fixed order; 0 for all. A hidden split is whole.
        agent: name of the agent, shown on the leaderboard.
        image_size: side length of images in pixels; None for the server's.

    Raises:
        UsageError: if the server does not have what the arguments name.
    """
    host = Host(
        language=lang, split=split, agent=agent, server=server, data=data, sensors=("rgb",), image_size=image_size
    )
    if host.is_hidden and episodes not in (0, host.episode_count):
        raise UsageError(f"episodes is {episodes}, but the hidden split {host.split!r} can only be played whole")
    sections = {} if host.is_hidden else host.episodes()
    ids = list(sections) or [f"episode {number}" for number in range(1, host.episode_count + 1)]
    samples = [
        Sample(id=episode_id, input=RULES, metadata={"section": sections[episode_id]} if sections else None)
        for episode_id in ids[: episodes or None]
    ]
    return Task(
        dataset=MemoryDataset(samples, name=f"arramon-{host.split}-{lang}"),
        solver=play_episode(EpisodeRuns(host)),
        scorer=run_score() if host.is_hidden else episode_score(),
        metadata={"split": host.split, "language": lang},
    )


@solver
def play_episode(runs: EpisodeRuns) -> Solver:
    """Return a solver that lets the model play an episode to its end."""

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        played = await runs.open(str(state.sample_id))
        episode, reason = played.episode, "the evaluation stopped before the episode's end"
        try:
            state.messages = [
                ChatMessageSystem(content=RULES),
                ChatMessageUser(content=content_of(await episode.look(), "")),
            ]
            state.tools = [look(episode), act(episode)]
            silent = 0
            while not episode.ended and silent < MAX_SILENT:
                state = await generate(state, tool_calls="single")
                silent = 0 if state.output.message.tool_calls else silent + 1
                if silent:
                    state.messages.append(ChatMessageUser(content=CALL_A_TOOL))
            reason = f"the model answered {MAX_SILENT} times without a tool call"
        finally:  # Also when a limit of Inspect is reached, which may cancel this task.
            with anyio.CancelScope(shield=True):
                state.store.set(RESULT, await played.finish(reason))
        return state

    return solve


@tool
def look(episode: AsyncRunEpisode) -> Tool:
    """Return the tool that shows the present observation."""

    async def execute() -> Content:
        """Show what you see now, with the step's number and the instruction; takes no step."""
        return content_of(await episode.look(), "")

    return execute


@tool
def act(episode: AsyncRunEpisode) -> Tool:
    """Return the tool that takes steps."""

    async def execute(step: int, actions: list[str]) -> Content | str:
        """Act one or more times, and show what you see then.

        Args:
            step: The number of the present step, as last shown.
            actions: 1 to 10 actions, each "forward", "left", "right" or "interact".
        """
        try:
            seen = await episode.act(step, actions_of(actions))
        except (UsageError, StepSpentError, StepAheadError) as error:
            raise ToolError(str(error)) from error
        return "The episode has ended." if seen is None else content_of(seen, episode.stop_reason)

    return execute


def content_of(seen: Observation, stop_reason: str) -> Content:
    """Return an observation as the content of a message."""
    url = picture_url(seen)
    return [ContentText(text=observation_text(seen, stop_reason)), *([] if url is None else [ContentImage(image=url)])]


def result_score(result: dict[str, Any], rows: str) -> Score:
    """Return the score from a result's rows of scores, with the result as metadata; unscored if there are none."""
    if result.get(rows) is None:
        return Score.unscored(reason="the scores of a hidden split are those of the whole run", metadata=result)
    return Score(value=headline(result[rows]), explanation=result["cause"], metadata=result)


CLUSTERED: dict[str, list[Metric]] = {metric: [mean(), stderr(cluster="section")] for metric in METRICS}
"""Metrics of scores of episodes: those of one section are correlated."""


@scorer(metrics=CLUSTERED)
def episode_score() -> Scorer:
    """Return a scorer that reads the server's scores of the sample's episode; its metadata has the receipt."""

    async def score(state: TaskState, target: Target) -> Score:  # noqa: ARG001 - Inspect's interface
        return result_score(state.store.get(RESULT), "scores")

    return score


@scorer(metrics={metric: [mean()] for metric in METRICS})
def run_score() -> Scorer:
    """Return a scorer for hidden splits: the sample that ends the run has the run's scores, the others have none."""

    async def score(state: TaskState, target: Target) -> Score:  # noqa: ARG001 - Inspect's interface
        return result_score(state.store.get(RESULT), "run_scores")

    return score

"""Results of the tools as structured data; their JSON schemas are published with the tools."""

from typing import Annotated, Any

from pydantic import BaseModel, Field

from arramon_client.agent import Observation
from arramon_client.mcp.words import depth_in_words, things_in_words
from arramon_client.runs.async_run import AsyncRunEpisode
from arramon_client.runs.info import RunInfo


class RunView(BaseModel):
    """A run: what it plays, its limits, and what is left of it."""

    id: Annotated[str, Field(description="Id of the run: pass it as `run`.")]
    state: Annotated[str, Field(description='"running", "complete" or "cancelled".')]
    split: str
    language: str
    agent: str
    sensors: list[str]
    episodes: Annotated[int, Field(description="Number of episodes.")]
    episodes_ended: int
    episodes_left: int
    steps_per_phase: Annotated[int, Field(description="Step limit of each phase.")]
    step_seconds: Annotated[float | None, Field(description="Time limit of a step; absent without clocks.")] = None
    bank_seconds: Annotated[
        float | None, Field(description="Seconds in the run's bank at its start, for steps that take longer.")
    ] = None
    created_at: str


class RunsView(BaseModel):
    """The participant's runs."""

    runs: Annotated[list[RunView], Field(description="The latest first.")]
    more: Annotated[int, Field(description="Number of further runs that were not listed.")]


class EpisodeView(BaseModel):
    """An episode with the observation that awaits an action, or its end."""

    id: Annotated[str, Field(description="Id of the episode: pass it as `episode`.")]
    ended: bool
    cause: Annotated[str | None, Field(description="Why it ended, such as AGENT_FINISHED or TIME_LIMIT.")] = None
    step: Annotated[int | None, Field(description="The step that awaits an action: pass it to `act`.")] = None
    turn: Annotated[int | None, Field(description="1 or 2.")] = None
    phase: Annotated[str | None, Field(description='"navigation" or "assembly".')] = None
    instruction: Annotated[str | None, Field(description="Instruction of this phase, in the run's language.")] = None
    steps_left: Annotated[int | None, Field(description="Steps left in this phase, including this one.")] = None
    seconds_left: Annotated[
        float | None, Field(description="Seconds left now until the episode times out; absent without clocks.")
    ] = None
    pose: Annotated[
        list[float] | None,
        Field(description="x, z, heading in degrees clockwise from +z; in the room column, row, heading."),
    ] = None
    depth: Annotated[str | None, Field(description="Distances at eye level, from left to right.")] = None
    visible: Annotated[list[str] | None, Field(description="Visible things, the nearest first.")] = None
    images: Annotated[list[str], Field(description="The images beside this text, in order.")] = []


class PlayView(BaseModel):
    """A run, and one of its episodes."""

    run: RunView
    episode: Annotated[EpisodeView | None, Field(description="Absent if the run is over.")] = None
    open_episodes: Annotated[list[str], Field(description="Ids of the run's open episodes.")]
    next: Annotated[str, Field(description="What can be done next.")]


class ActView(PlayView):
    """The result of an act."""

    taken: Annotated[
        int, Field(description="Number of the actions that are recorded, from the step on; 0 if a hidden run is over.")
    ]
    stopped: Annotated[str, Field(description="Why a plan stopped before its last action; empty if it did not.")]


class ReportView(BaseModel):
    """Scores of a run that is over."""

    run: RunView
    scores: Annotated[dict[str, dict[str, Any]], Field(description="By turn and metric: mean and its 95% interval.")]
    signature: Annotated[str, Field(description="Versions and settings with which the scores were computed.")]
    receipt: Annotated[str, Field(description="SHA-256 of the run's signed receipt.")]
    episodes: Annotated[list[dict[str, Any]] | None, Field(description="The episodes, if they were asked for.")] = None


def run_view(info: RunInfo) -> RunView:
    """Return a run's description."""
    has_clocks = info.step_seconds > 0
    return RunView(
        id=info.run_id,
        state=info.state,
        split=info.split,
        language=info.language,
        agent=info.agent,
        sensors=list(info.sensors),
        episodes=info.episodes,
        episodes_ended=info.ended,
        episodes_left=info.episodes - info.ended,
        steps_per_phase=info.steps_per_phase,
        step_seconds=info.step_seconds if has_clocks else None,
        bank_seconds=info.bank_seconds if has_clocks else None,
        created_at=info.created_at,
    )


def episode_view(episode: AsyncRunEpisode, seen: Observation, images: list[str]) -> EpisodeView:
    """Return an open episode with the observation that awaits an action.

    Args:
        episode: the episode.
        seen: the observation.
        images: descriptions of the images that are sent with it.
    """
    left = seen.seconds_left()
    return EpisodeView(
        id=episode.episode_id,
        ended=False,
        step=seen.step,
        turn=seen.turn,
        phase=seen.phase,
        instruction=seen.instruction,
        steps_left=seen.steps_left,
        seconds_left=None if left is None else round(left, 1),
        pose=None if seen.pose is None else [round(number, 3) for number in seen.pose],
        depth=None if seen.depth is None else depth_in_words(seen.depth),
        visible=None if seen.segmentation is None else things_in_words(seen, episode.episode.labels),
        images=images,
    )

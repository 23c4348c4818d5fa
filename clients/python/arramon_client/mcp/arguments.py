"""Arguments of the tools. Their types are checked strictly, and unknown arguments are refused."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from arramon_client.errors import UsageError
from arramon_client.printable import one_line
from arramon_client.runs.live_episode import MAX_PLAN
from arramon_client.world import DEFAULT_SENSORS, NOTE_BYTES

MAX_SHOWN = 80
"""Maximum length of a wrong value in an error message, in characters."""

RunId = Annotated[str, Field(max_length=64, description="Id of the run, from `start` or `runs`.")]
EpisodeId = Annotated[str, Field(min_length=1, max_length=200, description="Id of the episode, from `look` or `act`.")]
Sensor = Literal["rgb", "depth", "segmentation", "pose"]
ActionName = Literal["FORWARD", "LEFT", "RIGHT", "INTERACT"]
"""Names of `Action`."""


class Arguments(BaseModel):
    """Base class of all arguments."""

    model_config = ConfigDict(strict=True, extra="forbid")


Given = TypeVar("Given", bound=Arguments)


class StartArguments(Arguments):
    """Arguments of `start`."""

    language: Annotated[str, Field(max_length=20, description='Language of the instructions, such as "en" or "hi".')]
    agent: Annotated[str, Field(max_length=200, description="Name of whoever plays, such as the model's name.")]
    split: Annotated[str | None, Field(max_length=200, description="The split; by default the only one there is.")] = (
        None
    )
    episodes: Annotated[int, Field(ge=0, le=1_000_000, description="Number of episodes; 0 for all of the split.")] = 0
    episode_ids: Annotated[
        list[Annotated[str, Field(max_length=200)]],
        Field(max_length=10_000, description="Play only these episodes, in this order; open splits only."),
    ] = []
    sensors: Annotated[
        list[Sensor],
        Field(max_length=4, description="Sensors. Hidden splits offer rgb and depth only; [] for text alone."),
    ] = list(DEFAULT_SENSORS)  # type: ignore[arg-type]  # pydantic copies it, and checks it
    agent_arguments: Annotated[
        dict[str, str | int | float | bool],
        Field(max_length=16, description="Settings of the agent, such as the prompt's version; public with the run."),
    ] = {}


class RunsArguments(Arguments):
    """Arguments of `runs`."""

    state: Annotated[
        Literal["running", "complete", "cancelled"] | None, Field(description="List only runs in this state.")
    ] = None
    limit: Annotated[int, Field(ge=1, le=100, description="List at most this many, the latest first.")] = 20


class ViewArguments(Arguments):
    """Arguments that choose what an observation shows."""

    images: Annotated[
        list[Literal["rgb", "depth"]] | None,
        Field(max_length=2, description="Images to send; by default rgb, if the run has it; [] for none."),
    ] = None
    image_format: Annotated[Literal["jpeg", "png"], Field(description="Format of the images; png is lossless.")] = (
        "jpeg"
    )
    image_size: Annotated[int, Field(ge=0, le=1024, description="Side length in pixels; 0 for the run's own.")] = 0


class LookArguments(ViewArguments):
    """Arguments of `look`."""

    run: RunId
    episode: Annotated[str | None, Field(max_length=200, description="The episode; by default the open one.")] = None


class ActArguments(ViewArguments):
    """Arguments of `act`."""

    run: RunId
    episode: EpisodeId
    step: Annotated[int, Field(ge=0, description="Step of the observation that the actions answer.")]
    actions: Annotated[
        list[ActionName],
        Field(min_length=1, max_length=MAX_PLAN, description="One action, or several to take one after the other."),
    ]
    note: Annotated[
        str, Field(max_length=NOTE_BYTES, description="Text to store beside the first step, such as the reason.")
    ] = ""


class GiveUpArguments(Arguments):
    """Arguments of `give_up`."""

    run: RunId
    episode: EpisodeId
    reason: Annotated[str, Field(max_length=500, description="Why, for the host's log.")] = ""


class ReportArguments(Arguments):
    """Arguments of `report`."""

    run: RunId
    episodes: Annotated[bool, Field(description="Whether to list all episodes with their scores.")] = False


def checked(model: type[Given], arguments: Mapping[str, Any]) -> Given:
    """Return a call's arguments.

    Raises:
        UsageError: if one is unknown, missing or wrong; the message names all of them and what was expected.
    """
    try:
        return model.model_validate(dict(arguments))
    except ValidationError as error:
        faults = [_fault(each) for each in error.errors(include_url=False, include_context=False)[:5]]
        known = ", ".join(model.model_fields)
        raise UsageError(f"wrong arguments: {'; '.join(faults)} (the arguments are {known})") from error


def _fault(error: Any) -> str:
    where = ".".join(map(str, error["loc"]))
    wrong = "" if error["type"] == "missing" else f", not {one_line(repr(error['input'])[: 2 * MAX_SHOWN], MAX_SHOWN)}"
    return f"{where or 'arguments'}: {error['msg']}{wrong}"

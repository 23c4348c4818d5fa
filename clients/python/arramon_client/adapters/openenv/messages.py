"""Messages of the OpenEnv environment: action, observation and state, all of plain JSON."""

from typing import Any

from arramon_client.adapters.extras import extra
from arramon_client.adapters.model_view import MAX_ACTIONS, RULES

with extra("openenv"):
    from openenv.core.env_server.types import Action, Observation, State
    from pydantic import Field


class ArramonAction(Action):
    """One or more actions, for the step that the latest observation names."""

    step: int = Field(ge=0, description="`step` of the latest observation; sent again, it is not taken again")
    actions: list[str] = Field(
        min_length=1, max_length=MAX_ACTIONS, description='each "forward", "left", "right" or "interact"'
    )


class ArramonObservation(Observation):
    """What the agent sees; at the episode's end the result."""

    rules: str = Field(default=RULES, description="the rules of an episode")
    run_id: str = Field(default="", description="id of the run; `reset(resume=run_id)` goes on with it")
    step: int = Field(default=0, description="steps taken in this episode so far")
    turn: int = Field(default=0, description="1 or 2; 0 at the end")
    phase: str = Field(default="", description='"navigation" or "assembly"; empty at the end')
    steps_left: int = Field(default=0, description="steps left in this phase")
    instruction: str = Field(default="", description="the instruction of this turn and phase")
    stop_reason: str = Field(default="", description="why the latest actions stopped before the last one; empty if not")
    image: str | None = Field(default=None, description="what the agent sees, a PNG as data URL")
    result: dict[str, Any] | None = Field(default=None, description="at the end: cause, scores, receipt")


class ArramonState(State):
    """Where the episode is, without the ground truth."""

    run_id: str = ""
    language: str = ""
    split: str = ""
    done: bool = False

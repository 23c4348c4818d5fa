"""What the agent's tests share: observations, and behaviours of the fake endpoint."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from types import SimpleNamespace
from typing import Any

import numpy as np

from arramon_agents.vlm.agent import VlmAgent
from arramon_client.agent import Answer, Episode, Observation
from benchmarks.agents.fake_endpoint import Behaviour, Request, Response, is_sight_check, name_card, plan

KEY = "sk-test-0123456789abcdef"

EPISODE = Episode("e", "en", "tiny")


def seen(step: int, *, phase: str = "navigation", turn: int = 1, look: int | None = None, **given: Any) -> Observation:
    """An observation whose frame is its step's unless `look` names another."""
    rgb = np.full((32, 32, 3), (step if look is None else look) % 256, np.uint8)
    fields = {"episode_id": "e", "instruction": "Go to the mug.", "phase_step": step, "steps_left": 150 - step, **given}
    return Observation(turn=turn, phase=phase, step=step, rgb=rgb, **fields)


def always(*actions: str) -> Behaviour:
    """The behaviour that plans the same actions whatever is asked, and sees."""

    def answer(request: Request, number: int) -> Response:
        return name_card(request) if is_sight_check(request) else plan(request, actions)

    return answer


def in_turn(*responses: Behaviour) -> Behaviour:
    """The behaviour of each in its turn, and then of the last one."""
    return lambda request, number: responses[min(number, len(responses) - 1)](request, number)


@asynccontextmanager
async def playing(
    agent: VlmAgent, run_id: str = "r", episode: Episode = EPISODE, steps: int = 0
) -> AsyncIterator[VlmAgent]:
    """The agent with an open run of so many recorded steps, in which an episode has begun."""
    run: Any = SimpleNamespace(
        run_id=run_id, language=episode.language, sensors=agent.sensors, output=None, steps=steps
    )
    await agent.open(run)
    try:
        agent.begin(episode)
        yield agent
    finally:
        await agent.close()


async def action_of(agent: VlmAgent, observation: Observation) -> int:
    answer = await agent.act(observation)
    return int(answer.action if isinstance(answer, Answer) else answer)


async def note_of(agent: VlmAgent, observation: Observation) -> dict[str, Any]:
    answer = await agent.act(observation)
    assert isinstance(answer, Answer)
    assert isinstance(answer.note, dict)
    return answer.note

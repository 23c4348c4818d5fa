"""Checked calls of the methods of an agent that waits, which turn every failure into an AgentError."""

import asyncio
import inspect
from typing import Any, TypeGuard

from arramon_client.agent import Answer, AsyncAgent, Episode, Observation
from arramon_client.errors import AgentError, StopRun
from arramon_client.plugin.agent_calls import checked_answer, named
from arramon_client.plugin.tracebacks import own_frames


def is_async(agent: object) -> TypeGuard[AsyncAgent]:
    """Return whether an agent's `act` is a coroutine function, for single observations."""
    return inspect.iscoroutinefunction(getattr(agent, "act", None))


class AgentRaisedError(AgentError):
    """A method of the agent raised an exception; repeating the call may help if its cause passes."""


async def begin(agent: AsyncAgent, episode: Episode) -> None:
    """Call the agent's `begin`.

    Raises:
        AgentRaisedError: if the agent raises any other exception than StopRun.
    """
    await _call(agent, "begin", episode)


async def act(agent: AsyncAgent, observation: Observation) -> Answer:
    """Call the agent's `act`, and return its answer, with an action from 0 to 3.

    Raises:
        AgentRaisedError: if the agent raises any other exception than StopRun.
        AgentError: if it does not return a valid action, for example None.
    """
    return checked_answer(await _call(agent, "act", observation), observation)


async def replay(agent: AsyncAgent, observation: Observation) -> Answer:
    """Call the agent's `replay` with a recorded observation, and return its recorded action.

    Raises:
        AgentRaisedError: if the agent raises any other exception than StopRun.
    """
    assert observation.taken is not None
    await _call(agent, "replay", observation, observation.taken)
    return Answer(observation.taken)


async def call_optional(agent: object, method: str, *arguments: object) -> None:
    """Call a method that an agent need not have: `open`, `end` or `close`; another attribute is ignored.

    Raises:
        AgentRaisedError: if the agent raises any other exception than StopRun.
    """
    if callable(getattr(agent, method, None)):
        await _call(agent, method, *arguments)


async def _call(agent: object, method: str, *arguments: object) -> Any:
    try:
        result = getattr(agent, method)(*arguments)
        return await result if inspect.isawaitable(result) else result
    except StopRun:
        raise
    except asyncio.CancelledError as error:
        task = asyncio.current_task()
        if task is not None and task.cancelling():  # The client cancels this call.
            raise
        # Something that the agent awaits was cancelled: without this, the episode would silently stand still.
        raise AgentRaisedError(f"{method}() raised {named(error)}", own_frames(error)) from error
    except AgentError as error:  # The agent itself says what went wrong.
        raise AgentRaisedError(str(error), error.details) from error
    except (Exception, SystemExit) as error:
        raise AgentRaisedError(f"{method}() raised {named(error)}", own_frames(error)) from error

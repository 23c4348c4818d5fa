"""Checked calls of the methods of an agent that waits, which turn every failure into an AgentError."""

import inspect
from collections.abc import Callable
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
    await _call(agent.begin, "begin", episode)


async def act(agent: AsyncAgent, observation: Observation) -> Answer:
    """Call the agent's `act`, and return its answer, with an action from 0 to 3.

    Raises:
        AgentRaisedError: if the agent raises any other exception than StopRun.
        AgentError: if it does not return a valid action, for example None.
    """
    return checked_answer(await _call(agent.act, "act", observation), observation)


async def call_optional(agent: object, method: str, *arguments: object) -> None:
    """Call a method that an agent need not have: `open`, `replay`, `end` or `close`; another attribute is ignored.

    Raises:
        AgentRaisedError: if the agent raises any other exception than StopRun.
    """
    function = getattr(agent, method, None)
    if callable(function):
        await _call(function, method, *arguments)


async def _call(function: Callable[..., Any], name: str, *arguments: object) -> Any:
    try:
        result = function(*arguments)
        return await result if inspect.isawaitable(result) else result
    except StopRun:
        raise
    except (Exception, SystemExit) as error:
        raise AgentRaisedError(f"{name}() raised {named(error)}", own_frames(error)) from error

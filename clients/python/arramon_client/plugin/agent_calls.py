"""Checked calls of an agent's methods, which turn every failure into an AgentError for the agent's author."""

import inspect
import json
from collections.abc import Mapping, Sequence
from operator import index
from typing import Any

import numpy as np

from arramon_client.agent import Action, Agent, Answer, Episode, Observation, end_episode
from arramon_client.errors import AgentError, StopRun, UsageError
from arramon_client.notes import note_text
from arramon_client.plugin.shared_agent import EpisodesTakenOver
from arramon_client.plugin.tracebacks import own_frames

ACTIONS = "0 (forward), 1 (left), 2 (right) or 3 (interact)"

OPTIONAL = {"end": ("episode_id",), "replay": ("observation", "action")}
"""Parameters of the optional methods that are called while episodes are played."""


class ReportedAgentError(AgentError):
    """A failure of an agent in another process, where these calls have described it."""


def begin(agent: Agent, episode: Episode) -> None:
    """Call the agent's `begin`.

    Raises:
        AgentError: if the agent raises any other exception than StopRun.
    """
    try:
        agent.begin(episode)
    except (ReportedAgentError, StopRun):
        raise
    except (Exception, SystemExit) as error:
        raise AgentError(f"begin() raised {named(error)}", own_frames(error)) from error


def act(agent: Agent, observations: Sequence[Observation]) -> list[Answer]:
    """Call the agent's `act` on a batch, and return its answers, with actions from 0 to 3.

    Raises:
        AgentError: if the agent raises any exception, or does not return one valid action for each observation.
        StopRun: if the agent stops the run.
        EpisodesTakenOver: if another stream with the same agent has begun some of the episodes since.
    """
    try:
        answer: object = agent.act(observations)
    except (EpisodesTakenOver, ReportedAgentError, StopRun):
        raise
    except (Exception, SystemExit) as error:
        raise AgentError(f"act() raised {named(error)}", own_frames(error)) from error
    return _answers(answer, observations)


def can_replay(agent: object) -> bool:
    """Return whether the agent has a `replay`, to be called for recorded steps in place of `act`."""
    return callable(getattr(agent, "replay", None))


def replay(agent: Agent, observation: Observation) -> None:
    """Call the agent's `replay` with a recorded observation and its action.

    Raises:
        AgentError: if the agent raises any exception.
        EpisodesTakenOver: if another stream with the same agent has begun the episode since.
    """
    try:
        agent.replay(observation, observation.taken)  # type: ignore[attr-defined]  # see `can_replay`
    except (EpisodesTakenOver, ReportedAgentError, StopRun):
        raise
    except (Exception, SystemExit) as error:
        raise AgentError(f"replay() raised {named(error)}", own_frames(error)) from error


def end(agent: Agent, episode_id: str) -> None:
    """Call the agent's `end`, if it has one.

    Raises:
        AgentError: if the agent raises any exception.
    """
    try:
        end_episode(agent, episode_id)
    except ReportedAgentError:
        raise
    except (Exception, SystemExit) as error:
        raise AgentError(f"end() raised {named(error)}", own_frames(error)) from error


def run_report(agent: object) -> dict[str, Any]:
    """Return what the agent's `run_report` says of the run that it has played; empty if it has none.

    Raises:
        AgentError: if the agent raises any exception, or returns what JSON cannot hold.
    """
    method = getattr(agent, "run_report", None)
    if method is None:
        return {}
    try:
        content = method()
    except (Exception, SystemExit) as error:
        raise AgentError(f"run_report() raised {named(error)}", own_frames(error)) from error
    try:
        if isinstance(content, Mapping):
            return dict(json.loads(json.dumps(dict(content), allow_nan=False)))
    except (TypeError, ValueError):
        pass
    raise AgentError(f"run_report() returned {_shown(content)}; expected a mapping that JSON can hold")


def summary(agent: object) -> str:
    """Return one line of an agent's `run_summary` on what it has used so far; empty if it has none, or nothing to say.

    Raises:
        AgentError: if the agent raises any exception, or returns no text.
    """
    method = getattr(agent, "run_summary", None)
    if not callable(method):
        return ""
    try:
        text = method()
    except (Exception, SystemExit) as error:
        raise AgentError(f"run_summary() raised {named(error)}", own_frames(error)) from error
    if not isinstance(text, str):
        raise AgentError(f"run_summary() returned {_shown(text)}; expected a text")
    return " ".join(text.split())


def fault_of_optional_methods(agent: object) -> str:
    """Return why an agent's `end` or `replay` cannot be called; empty if it can, or if there is none."""
    return next(filter(None, (_fault_of_method(agent, name, parameters) for name, parameters in OPTIONAL.items())), "")


def _fault_of_method(agent: object, name: str, parameters: Sequence[str]) -> str:
    method, kind, call = getattr(agent, name, None), type(agent).__name__, f"{name}({', '.join(parameters)})"
    if method is None or (name == "replay" and not callable(method)):  # It may be a replay buffer, see `can_replay`.
        return ""
    if not callable(method):
        return f"{kind}.{name} is {_shown(method)}; expected a method {call}, or none"
    if inspect.iscoroutinefunction(method) and not inspect.iscoroutinefunction(getattr(agent, "act", None)):
        return f"{kind}.{name} is a coroutine function (async def); expected an ordinary method {call}, or none"
    try:
        signature = inspect.signature(method)
    except (ValueError, TypeError):  # Some callables that are not written in Python have no signature.
        return ""
    try:
        signature.bind(*parameters)
    except TypeError:
        return f"{kind} has {name}{signature}; expected a method that can be called as {call}, or none"
    return ""


def _answers(answer: object, observations: Sequence[Observation]) -> list[Answer]:
    if inspect.iscoroutine(answer) or inspect.isasyncgen(answer):
        if inspect.iscoroutine(answer):
            answer.close()
        raise AgentError(
            f"act() returned {type(answer).__name__.replace('_', ' ')}, expected actions; an agent that waits has a "
            "method `async def act(self, observation)` that returns one"
        )
    expected = f"act() must return a sequence with one action for each of the {len(observations)} observations"
    if isinstance(answer, str | bytes | dict | set):
        raise AgentError(f"{expected}; it returned {_shown(answer)}")
    try:
        length = len(answer)  # type: ignore[arg-type]
        items = list(answer)  # type: ignore[call-overload]
    except TypeError as error:
        raise AgentError(f"{expected}; it returned {_shown(answer)}") from error
    if length != len(observations):
        raise AgentError(f"{expected}; it returned {length}: {_shown(answer)}")
    return [checked_answer(item, observation) for item, observation in zip(items, observations, strict=True)]


def checked_answer(item: object, observation: Observation) -> Answer:
    """Return an agent's answer to one observation, with an action from 0 to 3.

    Raises:
        AgentError: if it is neither a valid action nor an `Answer` with a valid action and note.
    """
    if not isinstance(item, Answer):
        return Answer(_action(item, observation))
    try:
        text = note_text(item.note)
    except UsageError as error:
        raise AgentError(f"for episode {observation.episode_id}, step {observation.step}, {error}") from error
    return Answer(_action(item.action, observation), text or None)


def _action(item: object, observation: Observation) -> int:
    where = f"for episode {observation.episode_id}, step {observation.step}, act() returned {_shown(item)}"
    if isinstance(item, bool | np.bool_):
        raise AgentError(f"{where}; an action is {ACTIONS}")
    try:
        number = index(item)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise AgentError(f"{where}; an action is an integer: {ACTIONS}") from error
    if not 0 <= number < len(Action):
        raise AgentError(f"{where}; an action is {ACTIONS}")
    return number


def named(error: BaseException) -> str:
    """Return an exception as its type and message."""
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__


def _shown(value: object) -> str:
    text = f"{type(value).__name__} {value!r}" if value is not None else "None"
    return text if len(text) <= 120 else text[:117] + "..."

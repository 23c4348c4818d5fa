"""Copies of an agent in processes of their own, so that an agent that computes on one core uses several.

The client calls a copy like any other agent: each call is sent to the process through a pipe, and images through shared
memory.
"""

import math
import multiprocessing
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Agent, Answer, Episode, Observation
from arramon_client.errors import AgentError, StopRun
from arramon_client.local.cores import usable_cores
from arramon_client.plugin import agent_calls
from arramon_client.plugin.agent_calls import ReportedAgentError
from arramon_client.plugin.loader import load_agent

MEMORY = 1 << 25
"""Bytes of memory shared with each process, for the images of one batch; images beyond are sent through the pipe."""

MIN_EPISODES, MAX_PROCESSES = 4, 8
"""Number of parallel episodes for each process, below which a further process is not worth its start; maximum number of
processes by default."""

ALIGNMENT = 64
"""Alignment of images in the shared memory, in bytes."""

STOP_SECONDS = 2.0
"""Time limit for a process to end, in seconds."""

IMAGES = ("rgb", "depth", "segmentation")

_Memory = npt.NDArray[np.uint8]


class _Stored(NamedTuple):
    """Reference to an array in the shared memory."""

    place: int
    shape: tuple[int, ...]
    kind: str


class _Stop(NamedTuple):
    """A StopRun that the agent raised."""

    message: str
    limit: str


class _Failure(NamedTuple):
    """An AgentError that describes the agent's failure."""

    message: str
    details: str


def choose_processes(agent: object, requested: int | None, parallel: int | None, episodes: int | None) -> int:
    """Return the number of processes for an agent; 1 for the client's own process alone.

    Args:
        agent: the agent.
        requested: requested number; None for one per core if the agent has a true attribute `uses_processes`, but not
            more than there is work for.
        parallel: requested number of episodes to play in parallel; None for the default of each process.
        episodes: number of episodes to play; None if unknown.
    """
    at_once = min(each for each in (parallel, episodes, MAX_PROCESSES * MIN_EPISODES) if each is not None)
    if requested is not None:
        return requested if parallel is None else min(requested, parallel)
    if not getattr(agent, "uses_processes", False):
        return 1
    return max(1, min(usable_cores(), at_once // MIN_EPISODES))


@contextmanager
def agent_processes(
    count: int, agent: object, spec: str, arguments: Mapping[str, object]
) -> Iterator[list["AgentProcess"]]:
    """Start copies of an agent, each in a process of its own, and stop them at the end of the context.

    Args:
        count: number of copies; with 1 none is started, as the client's own process calls the agent itself.
        agent: the agent.
        spec, arguments: how it was loaded, as for `load_agent`.
    """
    with ExitStack() as stack:
        copies = []
        for _ in range(count if count > 1 else 0):
            copy = AgentProcess(spec, arguments, replays=agent_calls.can_replay(agent))
            stack.callback(copy.stop)
            copies.append(copy)
        yield copies


class AgentProcess:
    """An agent in a process of its own; its methods are those of `ReplayingAgent`, and wait for the process.

    They raise ReportedAgentError if the agent fails, and StopRun if it stops the run or its process has ended.

    Args:
        spec, arguments: as for `load_agent`, which is called in the process.
        replays: whether the agent has a `replay`.
    """

    def __init__(self, spec: str, arguments: Mapping[str, object], *, replays: bool = False) -> None:
        context = multiprocessing.get_context("spawn")  # gRPC's threads do not survive a fork.
        self._connection, other = context.Pipe()
        memory = context.RawArray("B", MEMORY)
        self._memory: _Memory = np.frombuffer(memory, np.uint8)
        self._process = context.Process(
            target=_serve, args=(other, memory, spec, dict(arguments)), name="arramon-agent", daemon=True
        )
        self._process.start()
        other.close()
        self.replay = self._replay if replays else None

    def begin(self, episode: Episode) -> None:
        """Start a new episode."""
        self._call("begin", episode)

    def act(self, observations: Sequence[Observation]) -> list[Answer]:
        """Return the agent's answers."""
        answers: list[Answer] = self._call("act", self._without_images(observations))
        return answers

    def end(self, episode_id: str) -> None:
        """Discard the state of an episode."""
        self._call("end", episode_id)

    def stop(self) -> None:
        """Stop the process."""
        self._connection.close()
        self._process.terminate()
        self._process.join(STOP_SECONDS)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()

    def _replay(self, observation: Observation, action: int) -> None:  # noqa: ARG002 - it is in `Observation.taken`
        self._call("replay", self._without_images([observation])[0])

    def _call(self, method: str, argument: object) -> Any:
        try:
            self._connection.send((method, argument))
            result = self._connection.recv()
        except (EOFError, OSError) as error:
            self._process.join(STOP_SECONDS)
            raise StopRun(f"a process of the agent has ended with exit code {self._process.exitcode}") from error
        if isinstance(result, _Stop):
            raise StopRun(*result)
        if isinstance(result, _Failure):
            raise ReportedAgentError(*result)
        return result

    def _without_images(self, observations: Sequence[Observation]) -> list[Observation]:
        """Return observations with references in place of their images, which are copied to the shared memory."""
        place, found = 0, []
        for observation in observations:
            stored: dict[str, Any] = {}
            for name in IMAGES:
                image = getattr(observation, name)
                if image is not None and place + image.nbytes <= MEMORY:
                    end = place + image.nbytes
                    self._memory[place:end].view(image.dtype).reshape(image.shape)[...] = image
                    stored[name] = _Stored(place, image.shape, image.dtype.str)
                    place = -(-end // ALIGNMENT) * ALIGNMENT
            found.append(replace(observation, **stored))
        return found


def _serve(connection: "Connection[Any, Any]", memory: Any, spec: str, arguments: Mapping[str, object]) -> None:
    """Answer calls until the client is gone: the target of the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # The client ends in order, and stops this process.
    images: _Memory = np.frombuffer(memory, np.uint8)
    loaded: Agent | AgentError  # An agent that cannot be loaded fails at each call.
    try:
        loaded = load_agent(spec, arguments)
    except AgentError as error:
        loaded = error
    while True:
        try:
            method, argument = connection.recv()
        except (EOFError, OSError):
            return
        try:
            if isinstance(loaded, AgentError):
                raise loaded
            result = _answer(loaded, method, argument, images)
        except StopRun as stop:
            result = _Stop(str(stop), stop.limit)
        except AgentError as error:
            result = _Failure(str(error), error.details)
        connection.send(result)


def _answer(agent: Agent, method: str, argument: Any, images: _Memory) -> object:
    """Call the agent's method, with checks."""
    match method:
        case "begin":
            agent_calls.begin(agent, argument)
        case "act":
            return agent_calls.act(agent, [_with_images(each, images) for each in argument])
        case "replay":
            agent_calls.replay(agent, _with_images(argument, images))
        case _:
            agent_calls.end(agent, argument)
    return None


def _with_images(observation: Observation, images: _Memory) -> Observation:
    """Return an observation with copies of its images: the agent may keep them."""
    found: dict[str, Any] = {}
    for name in IMAGES:
        stored = getattr(observation, name)
        if isinstance(stored, _Stored):
            kind = np.dtype(stored.kind)
            size = math.prod(stored.shape) * kind.itemsize
            image = images[stored.place : stored.place + size].view(kind).reshape(stored.shape).copy()
            image.flags.writeable = False
            found[name] = image
    return replace(observation, **found)

"""Several streams for one run: a lane for each of the server's processes, all asking the same agent."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import ExitStack
from dataclasses import replace
from itertools import cycle
from typing import Any, cast

import grpc

from arramon.v1 import evaluation_pb2, evaluation_pb2_grpc
from arramon_client.access import host_of, open_channel
from arramon_client.agent import Agent, Episode, Observation
from arramon_client.connection import CHANNEL_OPTIONS, Server
from arramon_client.play import Outcome, Progress, Settings, play


def play_in_lanes(
    server: Server,
    run: evaluation_pb2.Run,
    agent: Agent,
    settings: Settings,
    *,
    notify: Callable[[str], None] = lambda _: None,
    progress: Callable[[Progress], None] = lambda _: None,
    revive: Callable[[], None] = lambda: None,
) -> Outcome:
    """Plays a run to its end, over a stream to each of the server's processes that can be reached one by one.

    The episodes open at once are shared out among the lanes. The agent is asked by one lane at a time, with a batch of
    that lane's observations. A lane whose process is gone goes on at the common address.

    Args:
        server: as it answered.
        run, agent, settings, notify, progress, revive: as for `play`.

    Raises:
        ArramonClientError: what the first lane that failed raised; the others are given up.
    """
    addresses = list(server.info.addresses)[: settings.parallel]
    if len(addresses) < 2:
        return play(
            server.stub, run, agent, settings, address=server.address, notify=notify, progress=progress, revive=revive
        )
    shared, steps = _Shared(agent), _Sum(progress)
    access = replace(
        server.access, name=host_of(server.address)
    )  # They all have the certificate of the common address.
    with ExitStack() as stack:
        pool = stack.enter_context(ThreadPoolExecutor(len(addresses), "lane"))

        def start(number: int, address: str) -> Future[Outcome]:
            # Closed before the pool is waited for: whatever went wrong, no lane goes on.
            channel = stack.enter_context(open_channel(address, access, CHANNEL_OPTIONS))
            stub = cast(evaluation_pb2_grpc.EvaluationStub, _Fallback(channel, server))
            own, told = _share(settings, number, len(addresses)), steps.of(number)
            return pool.submit(
                play, stub, run, shared, own, address=address, notify=notify, progress=told, revive=revive
            )

        lanes = [start(number, address) for number, address in enumerate(addresses)]
        outcomes = [lane.result() for lane in as_completed(lanes)]
    return Outcome(
        run=outcomes[-1].run,
        steps=sum(outcome.steps for outcome in outcomes),
        failures=tuple(failure for outcome in outcomes for failure in outcome.failures),
        problems=tuple(problem for outcome in outcomes for problem in outcome.problems),
        reconnections=sum(outcome.reconnections for outcome in outcomes),
        actions={episode_id: sent for outcome in outcomes for episode_id, sent in outcome.actions.items()},
    )


def _share(settings: Settings, number: int, lanes: int) -> Settings:
    """A lane's part of the episodes that are open at once."""
    return replace(settings, parallel=settings.parallel // lanes + (number < settings.parallel % lanes))


class _Shared:
    """An agent that is asked by one lane at a time."""

    def __init__(self, agent: Agent) -> None:
        self._agent = agent
        self._lock = threading.Lock()

    def begin(self, episode: Episode) -> None:
        with self._lock:
            self._agent.begin(episode)

    def act(self, observations: Sequence[Observation]) -> Sequence[int]:
        with self._lock:
            return self._agent.act(observations)


class _Fallback:
    """Opens a lane's first stream at its own process, and after that broke in turn at the common address and there."""

    def __init__(self, channel: grpc.Channel, server: Server) -> None:
        self._stubs = cycle((evaluation_pb2_grpc.EvaluationStub(channel), server.stub))

    def Play(self, *arguments: Any, **named: Any) -> Any:  # noqa: N802 - gRPC's name
        return next(self._stubs).Play(*arguments, **named)


class _Sum:
    """Adds up what the lanes have done."""

    def __init__(self, progress: Callable[[Progress], None]) -> None:
        self._progress = progress
        self._steps: dict[int, int] = {}
        self._lock = threading.Lock()

    def of(self, number: int) -> Callable[[Progress], None]:
        """What a lane tells its progress to."""

        def tell(state: Progress) -> None:
            with self._lock:
                self._steps[number] = state.steps
                self._progress(replace(state, steps=sum(self._steps.values())))

        return tell

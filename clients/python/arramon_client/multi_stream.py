"""Play over several streams: one to each of the server's processes, all served by the same agent."""

import asyncio
import threading
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from itertools import cycle, islice
from typing import Any, cast

import grpc

from arramon.v1 import evaluation_pb2, evaluation_pb2_grpc
from arramon_client.agent import Agent, AsyncAgent
from arramon_client.async_play import StreamTarget, play_over
from arramon_client.closing import close_once
from arramon_client.errors import ServerUnreachableError
from arramon_client.loop_thread import run_to_end
from arramon_client.play import Outcome, Progress, Settings, play
from arramon_client.plugin.async_calls import is_async
from arramon_client.plugin.failures import FailureCounter
from arramon_client.plugin.shared_agent import SharedAgent, StreamAgent
from arramon_client.recording.recorder import Recording
from arramon_client.stopping import SIGNAL_SECONDS
from arramon_client.transport.access import host_of, is_local
from arramon_client.transport.channel import open_channel
from arramon_client.transport.connection import CHANNEL_OPTIONS, Server


def play_streams(
    server: Server,
    run: evaluation_pb2.Run,
    agent: Agent | AsyncAgent,
    settings: Settings,
    *,
    notify: Callable[[str], None] = lambda _: None,
    progress: Callable[[Progress], None] = lambda _: None,
    revive: Callable[[], None] = lambda: None,
    recording: Recording | None = None,
    copies: Sequence[Agent] = (),
) -> Outcome:
    """Play a run to its end, over one stream to each server process that has an address of its own.

    The parallel episodes are divided among the streams. The agent is called for one stream at a time, with a batch of
    that stream's observations; an agent that waits is played by `play_async`. If a server process dies, its stream
    reconnects at the common address.

    Args:
        server: the connected server.
        run, agent, settings, notify, progress, revive, recording: as for `play`.
        copies: copies of the agent that can be called at the same time, and are called in its place: there is at least
            one stream for each.

    Raises:
        ArramonClientError: the error of the first stream that failed; the others are closed.
    """
    if is_async(agent):
        return run_to_end(
            lambda notify: play_async(
                server,
                run,
                agent,
                settings,
                notify=notify,
                progress=progress,
                revive=revive,
                recording=recording,
            ),
            notify,
        )
    addresses = own_addresses(server)
    if len(addresses) < len(copies):
        addresses = [*islice(cycle(addresses or [server.address]), len(copies))]
    addresses = addresses[: settings.parallel]
    if len(addresses) < 2:
        return play(
            server.stub,
            run,
            agent,
            settings,
            address=server.address,
            notify=notify,
            progress=progress,
            revive=revive,
            recording=recording,
        )
    shared, progress_sum = SharedAgent(cast(Agent, agent)), _ProgressSum(progress)
    agents = cycle([shared.copy(copy) for copy in copies] or [shared])
    failure_counter = FailureCounter(keep_going=settings.keep_going)
    over = threading.Event()

    def notify_until_over(text: str) -> None:
        if not over.is_set():  # How the remaining streams end does not concern the participant.
            notify(text)

    with ExitStack() as stack:
        threads = stack.enter_context(_StreamThreads())

        def start(number: int, address: str) -> Future[Outcome]:
            # Closed before the threads are joined, so that no stream goes on after an error.
            stub = _fallback_stub(stack, server, address)
            own, report_progress = _share(settings, number, len(addresses)), progress_sum.callback(number)
            return threads.start(
                partial(
                    play,
                    stub,
                    run,
                    StreamAgent(next(agents)),
                    own,
                    address=address,
                    notify=notify_until_over,
                    progress=report_progress,
                    revive=revive,
                    recording=recording,
                    failure_counter=failure_counter,
                )
            )

        streams = [start(number, address) for number, address in enumerate(addresses)]
        stack.callback(over.set)
        outcomes = [stream.result() for stream in _completed(streams)]
    return Outcome(
        run=outcomes[-1].run,
        steps=sum(outcome.steps for outcome in outcomes),
        failures=tuple(failure for outcome in outcomes for failure in outcome.failures),
        problems=tuple(problem for outcome in outcomes for problem in outcome.problems),
        reconnections=sum(outcome.reconnections for outcome in outcomes),
        actions={episode_id: sent for outcome in outcomes for episode_id, sent in outcome.actions.items()},
    )


async def play_async(
    server: Server,
    run: evaluation_pb2.Run,
    agent: Agent | AsyncAgent,
    settings: Settings,
    *,
    notify: Callable[[str], None] = lambda _: None,
    progress: Callable[[Progress], None] = lambda _: None,
    revive: Callable[[], None] = lambda: None,
    recording: Recording | None = None,
) -> Outcome:
    """Play a run to its end in an event loop, over one stream to each server process that has an address of its own.

    An agent that waits (`AsyncAgent`) plays each open episode in a task of its own. Any other agent is called in
    another thread, as by `play_streams`.

    Args:
        server: the connected server.
        run, agent, settings, notify, progress, revive, recording: as for `play`; `notify` and `revive` are called in
            other threads.

    Raises:
        StopRun: if the agent raises it; other calls of `act` are completed, and the run can be resumed.
        AgentStoppedError: if the agent still fails after `settings.retries`, and `settings` asks to stop; likewise.
        ArramonClientError: as for `play`.
    """
    if not is_async(agent):
        batch_agent = cast(Agent, agent)
        return await asyncio.to_thread(
            play_streams, server, run, batch_agent, settings,
            notify=notify, progress=progress, revive=revive, recording=recording,
        )  # fmt: skip
    addresses = own_addresses(server)[: settings.parallel]
    with ExitStack() as stack:
        targets = [StreamTarget(server.stub, server.address, settings)]
        if len(addresses) > 1:
            targets = [
                StreamTarget(_fallback_stub(stack, server, address), address, _share(settings, number, len(addresses)))
                for number, address in enumerate(addresses)
            ]
        return await play_over(
            targets, run, agent, settings,
            notify=notify, progress=progress, revive=revive, recording=recording,
        )  # fmt: skip


def _completed(futures: Collection[Future[Outcome]]) -> Iterator[Future[Outcome]]:
    """Yield futures as they complete, waking twice a second for signals that were delivered to another thread."""
    waiting = set(futures)
    while waiting:
        done, waiting = wait(waiting, timeout=SIGNAL_SECONDS, return_when=FIRST_COMPLETED)
        yield from done


class _StreamThreads:
    """Threads of the streams, joined at the end of the context unless the client is interrupted.

    They are daemon threads, so that an interrupted client exits without waiting for a slow agent.
    """

    def __init__(self) -> None:
        self._threads: list[threading.Thread] = []

    def __enter__(self) -> "_StreamThreads":
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None and issubclass(kind, KeyboardInterrupt):
            return
        for thread in self._threads:
            thread.join()

    def start(self, work: Callable[[], Outcome]) -> Future[Outcome]:
        """Start a thread, and return a future with the result or exception of its work."""
        future: Future[Outcome] = Future()

        def run() -> None:
            try:
                future.set_result(work())
            except BaseException as error:  # noqa: BLE001 - raised again by `Future.result`
                future.set_exception(error)

        self._threads.append(threading.Thread(target=run, name=f"stream-{len(self._threads)}", daemon=True))
        self._threads[-1].start()
        return future


def own_addresses(server: Server) -> list[str]:
    """Return the addresses of the server's processes on this machine; those that a remote server names are ignored."""
    addresses = dict.fromkeys(server.info.addresses)
    return [each for each in addresses if is_local(each)] if is_local(server.address) else []


def _share(settings: Settings, number: int, streams: int) -> Settings:
    """Return the settings of one stream, with its share of the parallel episodes."""
    return replace(settings, parallel=settings.parallel // streams + (number < settings.parallel % streams))


def _fallback_stub(stack: ExitStack, server: Server, address: str) -> evaluation_pb2_grpc.EvaluationStub:
    """Return a stub that opens streams at a server process's own address, and else at the common one."""
    # All processes have the certificate of the common address.
    access = replace(server.access, name=host_of(server.address))
    channel = open_channel(address, access, CHANNEL_OPTIONS)
    fallback = _FallbackStub(channel, server)
    stack.callback(close_once(fallback, channel.close))
    stack.callback(fallback.close)
    return cast(evaluation_pb2_grpc.EvaluationStub, fallback)


class _FallbackStub:
    """Stub that opens streams alternately at a server process's own address and at the common address."""

    def __init__(self, channel: grpc.Channel, server: Server) -> None:
        self._stubs = cycle((evaluation_pb2_grpc.EvaluationStub(channel), server.stub))
        self._lock = threading.Lock()
        self._call: Any = None
        self._closed = False

    def Play(self, *arguments: Any, **named: Any) -> Any:  # noqa: N802 - gRPC's name
        with self._lock:
            if self._closed:
                raise ServerUnreachableError("this stream is closed, as another one ended the run")
            self._call = next(self._stubs).Play(*arguments, **named)
            return self._call

    def close(self) -> None:
        """Cancel the current stream, and refuse to open another one."""
        with self._lock:
            self._closed = True
            if self._call is not None:
                self._call.cancel()


class _ProgressSum:
    """Progress summed over all streams."""

    def __init__(self, progress: Callable[[Progress], None]) -> None:
        self._progress = progress
        self._steps: dict[int, int] = {}
        self._lock = threading.Lock()

    def callback(self, number: int) -> Callable[[Progress], None]:
        """Return the progress callback of one stream."""

        def report(state: Progress) -> None:
            with self._lock:
                self._steps[number] = state.steps
                self._progress(replace(state, steps=sum(self._steps.values())))

        return report

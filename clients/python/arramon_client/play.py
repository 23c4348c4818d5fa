"""The play loop: pass batches between the server's stream and the agent, and reconnect when the stream breaks."""

from collections.abc import Callable
from typing import cast

from arramon.v1 import evaluation_pb2, evaluation_pb2_grpc
from arramon_client.agent import Agent, AsyncAgent
from arramon_client.async_play import StreamTarget, play_over
from arramon_client.errors import AgentError
from arramon_client.loop_thread import run_to_end
from arramon_client.play_results import Outcome as Outcome
from arramon_client.play_results import Progress as Progress
from arramon_client.player_streams import BACKLOG, PlayerStreams
from arramon_client.plugin import agent_calls
from arramon_client.plugin.async_calls import is_async
from arramon_client.plugin.failures import FailureCounter
from arramon_client.recording.recorder import EpisodeRecorder
from arramon_client.session import Session
from arramon_client.settings import Settings as Settings
from arramon_client.transport.retry import Retry
from arramon_client.transport.stream import PlayStream


def play(
    stub: evaluation_pb2_grpc.EvaluationStub,
    run: evaluation_pb2.Run,
    agent: Agent | AsyncAgent,
    settings: Settings,
    *,
    address: str = "the server",
    notify: Callable[[str], None] = lambda _: None,
    progress: Callable[[Progress], None] = lambda _: None,
    revive: Callable[[], None] = lambda: None,
    recording: EpisodeRecorder | None = None,
    failure_counter: FailureCounter | None = None,
) -> Outcome:
    """Play a run to its end.

    Args:
        stub: stub of the server.
        run: the run as created.
        agent: the agent. Between two `begin` calls for an episode, it gets each of its steps once and in order. Its
            `end`, if it has one, is called when an episode has ended; not for episodes that are open when this raises.
            An agent that waits (`AsyncAgent`) is played in an event loop, as by `play_async`.
        settings: settings of the session.
        address: address of the server, for messages.
        notify: called with messages for the participant.
        progress: called with the run's progress after each batch.
        revive: called before each attempt to reconnect, for example to restart an embedded server.
        recording: records what the agent perceives and does.
        failure_counter: counter of the agent's failures, shared with the run's other streams.

    Raises:
        AgentError: if the agent has an `end` or a `replay` that cannot be called; nothing is played.
        StopRun: if the agent raises it; the run can be resumed.
        AgentStoppedError: if the agent fails early or often enough to stop the run; the run can be resumed.
        ServerUnreachableError: if the server is away for longer than `settings.patience`; the run can be resumed.
        RefusedError, VersionMismatchError, MessageTooLargeError: if the server refuses the stream.
        ProtocolError: if client or server violates the protocol.
    """
    fault = agent_calls.fault_of_optional_methods(agent)
    if fault:
        raise AgentError(f"the agent cannot play: {fault}")
    if is_async(agent):
        target, waiting_agent = StreamTarget(stub, address, settings), agent
        return run_to_end(
            lambda notify: play_over(
                [target],
                run,
                waiting_agent,
                settings,
                notify=notify,
                progress=progress,
                revive=revive,
                recording=recording,
            ),
            notify,
        )
    failure_counter = failure_counter or FailureCounter(keep_going=settings.keep_going)
    session = Session(run, cast(Agent, agent), notify, failure_counter, recording)
    streams = PlayerStreams(stub, session, settings, address=address, notify=notify, revive=revive)
    streams.play(lambda stream: _play_stream(stream, session, progress, streams.retry))
    failures, problems = tuple(session.failures), tuple(session.problems)
    return Outcome(session.run, session.steps, failures, problems, streams.reconnections, session.actions)


def _play_stream(stream: PlayStream, session: Session, progress: Callable[[Progress], None], retry: Retry) -> None:
    """Pass batches between stream and agent until the run ends or a new stream is needed.

    Raises:
        grpc.RpcError, StreamEnded: when the stream breaks or ends.
    """
    while not session.ended and not session.must_reopen:
        before = session.advances
        if session.backlog < BACKLOG:
            for event in stream.receive(wait=session.backlog == 0):
                session.take(event)
        if session.advances > before:
            retry.succeeded()
        if session.must_reopen:
            return
        acts = session.answer()
        if acts:
            stream.send(acts)
        progress(Progress(session.run.episodes, session.episodes_ended, session.steps))

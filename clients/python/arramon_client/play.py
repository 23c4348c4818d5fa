"""The play loop: pass batches between the server's stream and the agent, and reconnect when the stream breaks."""

import uuid
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import grpc

from arramon.v1 import evaluation_pb2, evaluation_pb2_grpc, types_pb2
from arramon_client.agent import Agent
from arramon_client.errors import AgentError, ProtocolError
from arramon_client.plugin import agent_calls
from arramon_client.plugin.failures import FailureCounter
from arramon_client.recording.recorder import EpisodeRecorder
from arramon_client.session import AgentFailure, Session
from arramon_client.transport.connection import CONNECTION_LOST, explain
from arramon_client.transport.images import ImagesUnreadableError
from arramon_client.transport.incoming import details_of
from arramon_client.transport.retry import PATIENCE, Retry
from arramon_client.transport.stream import PlayStream, StreamEnded

BACKLOG = 256
"""Maximum number of observations that wait for the agent; reading from the stream pauses at this limit."""


@dataclass(frozen=True)
class Progress:
    """Progress of a run.

    Attributes:
        episodes: episodes of the run.
        ended: how many of them have ended, including those that other players played.
        steps: steps taken by this player's agent.
    """

    episodes: int
    ended: int
    steps: int


@dataclass(frozen=True)
class Settings:
    """Settings of a play session.

    Attributes:
        parallel: episodes to play in parallel.
        encoding: encoding of images.
        jpeg_quality: 1 to 100, with JPEG only; 0 for the server's default.
        image_size: side length of images in pixels; 0 for the server's first size.
        resume: take over the run's open episodes, and replay their histories to the agent.
        patience: seconds to keep reconnecting without receiving anything new from the server.
        keep_going: give up every episode in which the agent fails, however many. Otherwise the run stops if the agent
            fails before its first valid action, or in `failures.FAILURES_IN_A_ROW` episodes in a row.
    """

    parallel: int
    encoding: types_pb2.Encoding.ValueType = types_pb2.ENCODING_UNSPECIFIED
    jpeg_quality: int = 0
    image_size: int = 0
    resume: bool = False
    patience: float = PATIENCE
    keep_going: bool = False


@dataclass(frozen=True)
class Outcome:
    """The result of playing a run to its end.

    Attributes:
        run: the complete run.
        steps: steps taken by this player's agent.
        failures: the agent's failures.
        problems: descriptions of the problems that the server reported.
        reconnections: number of times that the stream was reopened.
        actions: actions sent, by episode, as in `Session.actions`.
    """

    run: evaluation_pb2.Run
    steps: int
    failures: tuple[AgentFailure, ...]
    problems: tuple[str, ...]
    reconnections: int
    actions: Mapping[str, Sequence[int]] = field(default_factory=dict)


def play(
    stub: evaluation_pb2_grpc.EvaluationStub,
    run: evaluation_pb2.Run,
    agent: Agent,
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
        settings: settings of the session.
        address: address of the server, for messages.
        notify: called with messages for the participant.
        progress: called with the run's progress after each batch.
        revive: called before each attempt to reconnect, for example to restart an embedded server.
        recording: records what the agent perceives and does.
        failure_counter: counter of the agent's failures, shared with the run's other streams.

    Raises:
        AgentError: if the agent has an `end` that cannot be called as `end(episode_id)`; nothing is played.
        AgentStoppedError: if the agent fails early or often enough to stop the run; the run can be resumed.
        ServerUnreachableError: if the server is away for longer than `settings.patience`; the run can be resumed.
        RefusedError, VersionMismatchError, MessageTooLargeError: if the server refuses the stream.
        ProtocolError: if client or server violates the protocol.
    """
    fault = agent_calls.fault_of_end(agent)
    if fault:
        raise AgentError(f"the agent cannot play: {fault}")
    failure_counter = failure_counter or FailureCounter(keep_going=settings.keep_going)
    session = Session(run, agent, notify, failure_counter, recording)
    retry = Retry(run.run_id, settings.patience, notify)
    player, reconnections, adopt = uuid.uuid4().hex, 0, settings.resume
    while True:
        history = adopt or session.needs_history
        opening = evaluation_pb2.Open(
            run_id=run.run_id,
            player=player,
            max_episodes=settings.parallel,
            encoding=settings.encoding,
            jpeg_quality=settings.jpeg_quality,
            image_size=settings.image_size,
            history=history,
            adopt=adopt,
        )
        before, broken, moved = session.advances, "", False
        stream = PlayStream(stub, opening)
        try:
            is_shared = settings.encoding == types_pb2.ENCODING_SHARED
            session.start_stream(history=history, max_episodes=settings.parallel, shared=is_shared)
            _play_stream(stream, session, progress, retry)
        except ImagesUnreadableError as error:
            if settings.encoding == types_pb2.ENCODING_RAW:
                raise ProtocolError(f"the server uses an encoding that was not requested: {error}") from error
            notify(f"images are sent in messages: {error}")
            settings = replace(settings, encoding=types_pb2.ENCODING_RAW)
        except StreamEnded:
            broken, moved = "the server closed the stream", True
        except grpc.RpcError as error:
            if error.code() not in CONNECTION_LOST:
                raise explain(error, address) from error
            broken = f"{error.code().name}: {details_of(error)}"
        finally:
            stream.close()
        if session.ended:
            failures, problems = tuple(session.failures), tuple(session.problems)
            return Outcome(session.run, session.steps, failures, problems, reconnections, session.actions)
        adopt = adopt and session.advances == before
        reconnections += 1
        if broken:
            retry.wait(broken, quiet=moved)
            revive()


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

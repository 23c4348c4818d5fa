"""The play loop: opens a stream, carries batches between the server and the agent, and opens another when it breaks."""

import uuid
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import grpc

from arramon.v1 import evaluation_pb2, evaluation_pb2_grpc, types_pb2
from arramon_client.agent import Agent
from arramon_client.connection import BROKEN, explain
from arramon_client.errors import ProtocolError
from arramon_client.retry import PATIENCE, Retry
from arramon_client.session import AgentFailure, Session
from arramon_client.sharing import NotSharedError
from arramon_client.stream import PlayStream, StreamEnded

BACKLOG = 256
"""Observations that wait for the agent before more are taken from the stream."""


@dataclass(frozen=True)
class Progress:
    """How far the run is.

    Attributes:
        episodes: of the run.
        ended: of these, whoever played them.
        steps: that this player's agent has taken.
    """

    episodes: int
    ended: int
    steps: int


@dataclass(frozen=True)
class Settings:
    """How a run is played.

    Attributes:
        parallel: episodes to have open at once.
        encoding: of images.
        jpeg_quality: 1 to 100, with JPEG only; 0 for the server's default.
        image_size: side length in pixels; 0 for the server's first.
        resume: the agent is new to the run: take over its open episodes, and rebuild the agent's memory of each.
        patience: seconds without anything new from the server, while connections break, before it is given up.
    """

    parallel: int
    encoding: types_pb2.Encoding.ValueType = types_pb2.ENCODING_UNSPECIFIED
    jpeg_quality: int = 0
    image_size: int = 0
    resume: bool = False
    patience: float = PATIENCE


@dataclass(frozen=True)
class Outcome:
    """What became of a run.

    Attributes:
        run: complete.
        steps: that this player's agent took.
        failures: each time that the agent failed.
        problems: what the server reported, in words.
        reconnections: how often the stream was opened again.
        actions: that were sent, by episode, as in `Session.actions`.
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
) -> Outcome:
    """Plays a run to its end.

    Args:
        stub: the server.
        run: as it was created.
        agent: what plays. Between two `begin`s of an episode it is shown each of its steps once, and in order.
        settings: how.
        address: of the server, for messages.
        notify: is told what a participant should read at once.
        progress: is told how far the run is, after each batch.
        revive: is called before each attempt to reconnect, such as to start an embedded server again.

    Raises:
        ServerUnreachableError: if the server stays away for longer than `settings.patience`; the run can be resumed.
        RefusedError, VersionMismatchError, MessageTooLargeError: if the server will not have the stream.
        ProtocolError: if client and server misunderstand each other.
    """
    session = Session(run, agent, notify)
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
            session.start_stream(history=history)
            _play_stream(stream, session, progress, retry)
        except NotSharedError as error:
            if settings.encoding != types_pb2.ENCODING_SHARED:
                raise ProtocolError(f"the server shares memory that was not asked for: {error}") from error
            notify(f"images travel in messages: {error}")
            settings = replace(settings, encoding=types_pb2.ENCODING_RAW)
        except StreamEnded:
            broken, moved = "the server closed the stream", True
        except grpc.RpcError as error:
            if error.code() not in BROKEN:
                raise explain(error, address) from error
            broken = f"{error.code().name}: {error.details()}"
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
    """Carries batches until the run ends, or until the stream is of no more use.

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

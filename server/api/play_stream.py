"""Handler of one Play stream: converts between the client's messages and the engine's events."""

import asyncio
import uuid
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Sequence
from functools import partial
from weakref import WeakKeyDictionary

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_server.api.encoding_choice import choose_encoder, offered_encodings
from arramon_server.api.messages import ACTIONS, LABEL_MESSAGES, PHASES, oracle_message, pose_message, run_message
from arramon_server.api.shared_memory import IMAGE_SENSORS
from arramon_server.api.wire import Data, Parts, observation_event, response_of
from arramon_server.configuration.config import Config
from arramon_server.errors import ArraMonError, BadInput
from arramon_server.image_threads import ImageThreads
from arramon_server.runs.accounts.callers import Caller
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.play.events import (
    EpisodeEnded,
    EpisodeStarted,
    Event,
    Observed,
    Opened,
    PhaseOver,
    Problem,
    RunEnded,
)
from arramon_server.runs.play.stream import Act, Stream
from arramon_server.runs.service import Runs
from arramon_server.sim.cameras import Frame
from arramon_server.sim.view import visible_pose
from arramon_server.visible_text import is_visible, shown

Encoding = tuple[Sequence[types_pb2.Image], Callable[[], Sequence[Data]]]
"""Images being encoded: their messages, and a function that completes the messages and returns the data of each."""

MAX_ACTS = 4096
"""Maximum number of acts in a message, four per open episode of a stream, so that no message delays all others."""


MAX_REASON_LENGTH = 500
"""Maximum length of the stored reason for forfeiting an episode, a note for the host."""


class PlayHandler:
    """Serves one Play stream.

    Args:
        open_: the client's first message.
        caller: the authenticated caller.
        runs: storage of the runs.
        engine: plays the episodes.
        config: the server's settings.
        threads: threads that compress images.

    Raises:
        ArraMonError: if the run cannot be played, or a field of `open_` is not allowed.
    """

    def __init__(
        self,
        open_: pb.Open,
        caller: Caller,
        runs: Runs,
        engine: Engine,
        config: Config,
        threads: ImageThreads,
    ) -> None:
        self._outbox: asyncio.Queue[bytes | ArraMonError | None] = asyncio.Queue()
        self._waiting = 0  # Bytes in the outbox.
        self._engine = engine
        self._threads = threads
        self._started_encodings: WeakKeyDictionary[Frame, Encoding] = WeakKeyDictionary()
        if open_.image_size and open_.image_size not in config.image_sizes:
            sizes = ", ".join(map(str, config.image_sizes))
            raise BadInput(f"image_size is {open_.image_size}, expected one of {sizes}")
        if not 1 <= open_.max_episodes <= config.max_episodes_per_stream:
            raise BadInput(f"max_episodes is {open_.max_episodes}, expected 1 to {config.max_episodes_per_stream}")
        if len(open_.player) > 100:
            raise BadInput(f"the player's name has {len(open_.player)} characters; at most 100 are allowed")
        if not is_visible(open_.player):
            raise BadInput(f"the player's name is {open_.player!r}, expected visible text")
        run, size = runs.playable(caller, open_.run_id), open_.image_size or config.image_sizes[0]
        self._image_sensors = [name for name in IMAGE_SENSORS if name in run.sensors]
        self._encoder = choose_encoder(
            open_.encoding,
            open_.jpeg_quality,
            offered_encodings(config.listen),
            episodes=open_.max_episodes,
            sensors=run.sensors,
            size=size,
        )
        self._stream = Stream(
            run=run,
            player=open_.player or uuid.uuid4().hex,
            max_episodes=open_.max_episodes,
            image_size=size,
            images=f"{self._encoder.form}-{size}" if self._image_sensors else "",
            history=open_.history,
            adopt=open_.adopt,
            prepare=self._prepare if self._encoder.compresses else None,
            canvas=self._encoder.canvas,
            deliver=self._deliver,
            close=self._outbox.put_nowait,
            backlog=lambda: self._waiting,
        )

    @property
    def stream(self) -> Stream:
        """The stream, as the engine handles it."""
        return self._stream

    async def serve(self, requests: AsyncIterator[pb.PlayRequest]) -> AsyncGenerator[bytes]:
        """Yield serialized responses until the run ends, the client leaves, or an error closes the stream.

        Raises:
            ArraMonError: the error that closed the stream.
        """
        with self._encoder:
            reader = asyncio.create_task(self._read(requests))
            try:
                self._engine.join(self._stream)
                while (item := await self._outbox.get()) is not None:
                    if isinstance(item, ArraMonError):
                        raise item
                    yield item
                    self._waiting -= len(item)
                    self._engine.wake()
            finally:
                self._engine.leave(self._stream)
                reader.cancel()

    async def _read(self, requests: AsyncIterator[pb.PlayRequest]) -> None:
        """Pass the client's messages to the engine. A client that half-closes the stream has left."""
        try:
            async for request in requests:
                self._engine.ask(self._stream, _acts(request))
                await self._stream.wait_for_room()
        except ArraMonError as error:
            self._outbox.put_nowait(error)
        else:
            self._outbox.put_nowait(None)

    def _prepare(self, event: Observed) -> None:
        """Start compressing an observation's images in a thread; `_deliver` waits for the result."""
        if event.frame is not None:
            heads, encode = self._encoding(event, event.frame)
            self._started_encodings[event.frame] = heads, self._threads.begin(encode)

    def _deliver(self, events: Sequence[Event]) -> None:
        response = response_of([self._event(event) for event in events])
        self._waiting += len(response)
        self._outbox.put_nowait(response)

    def _event(self, event: Event) -> Parts:
        """Serialize an event."""
        if isinstance(event, Observed):
            return self._observation(event)
        message = pb.Event()
        self._write(event, message)
        return [message.SerializeToString()]

    def _write(self, event: Event, message: pb.Event) -> None:
        match event:
            case EpisodeStarted():
                message.episode_started.CopyFrom(self._started(event))
            case PhaseOver(episode_id, phase):
                over = message.phase_ended
                over.episode_id, over.turn, over.forced = episode_id, phase.turn, phase.forced
                over.phase = PHASES[phase.phase]
            case EpisodeEnded(episode_id, cause, ended):
                end = message.episode_ended
                end.episode_id, end.episodes_ended = episode_id, ended
                end.cause = types_pb2.Cause.Value(f"CAUSE_{cause}")
                self._encoder.forget(episode_id)
            case Opened(run, progress, episode_ids):
                opened = message.opened
                opened.run.CopyFrom(run_message(run, progress))
                opened.episode_ids.extend(episode_ids)
                self._encoder.announce(opened)
                opened.image_size = self._stream.image_size
                if "segmentation" in run.sensors:
                    opened.labels.extend(LABEL_MESSAGES)
            case Problem(code, text, episode_id, step):
                problem = message.problem
                problem.message, problem.episode_id, problem.step = text, episode_id, step
                problem.code = pb.Problem.Code.Value(f"CODE_{code}")
            case RunEnded():
                message.run_ended.run.CopyFrom(run_message(event.run, event.progress))

    def _started(self, event: EpisodeStarted) -> pb.EpisodeStarted:
        message = pb.EpisodeStarted(
            episode_id=event.episode.episode_id, language=event.run.language, split=event.run.split, step=event.step
        )
        if "oracle" in event.run.sensors:
            message.oracle.CopyFrom(oracle_message(event.episode, event.scene))
        return message

    def _observation(self, event: Observed) -> Parts:
        state, sensors, message = event.state, event.run.sensors, pb.Observation()
        message.episode_id, message.step, message.turn = event.episode.episode_id, state.step, state.turn
        message.phase = PHASES[state.phase]
        message.instruction = event.episode.instruction(event.run.language, state.turn, state.phase.value)
        message.phase_step, message.steps_left = state.phase_step, event.steps_left
        if event.taken is not None:
            message.taken = ACTIONS[event.taken]
        if event.time_left is not None:
            message.step_seconds_left = event.time_left.step_seconds
            message.bank_seconds_left = event.time_left.bank_seconds
        if "pose" in sensors:
            message.pose.CopyFrom(pose_message(visible_pose(state)))
        if event.frame is None:
            return observation_event(message, ())
        has_begun = event.frame in self._started_encodings
        heads, encode = self._started_encodings.pop(event.frame) if has_begun else self._encoding(event, event.frame)
        data = encode()
        return observation_event(message, list(zip(self._image_sensors, heads, data, strict=True)))

    def _encoding(self, event: Observed, frame: Frame) -> Encoding:
        """Return a deferred encoding of an observation's images. It holds no reference to the frame."""
        images = [(getattr(frame, name), types_pb2.Image()) for name in self._image_sensors]
        encode = partial(self._encoder.encode, event.episode.episode_id, images, latest=event.taken is None)
        return [image for _, image in images], encode


def _acts(request: pb.PlayRequest) -> list[Act]:
    """Return the acts in a message after a stream's first one.

    Raises:
        BadInput: if the message is not `actions`, or holds too many acts.
    """
    if request.WhichOneof("message") != "actions":
        raise BadInput("a stream's first message is `open`, every further one is `actions`")
    if len(request.actions.acts) > MAX_ACTS:
        raise BadInput(f"a message holds {len(request.actions.acts)} acts; at most {MAX_ACTS} are allowed")
    return [_act(act) for act in request.actions.acts]


def _act(act: pb.Act) -> Act:
    choice = act.WhichOneof("choice")
    return Act(
        act.episode_id,
        act.step,
        action=act.action if choice == "action" else None,
        forfeit=shown(act.forfeit.reason[:MAX_REASON_LENGTH]) if choice == "forfeit" else None,
    )

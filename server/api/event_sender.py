"""The transport of one Play stream: encodes the engine's events as protocol buffers, and queues the responses."""

import asyncio
from collections.abc import Iterable, Sequence

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_server.api.encoding import ImageEncoder
from arramon_server.api.messages import ACTIONS, LABEL_MESSAGES, PHASES, oracle_message, pose_message, run_message
from arramon_server.api.wire import EncodedImage, Parts, observation_event, response_of
from arramon_server.errors import ArraMonError
from arramon_server.image_threads import ImageThreads
from arramon_server.runs.play.events import (
    ActionProblem,
    Encoding,
    EpisodeEnded,
    EpisodeStarted,
    Event,
    Observed,
    PhaseFinished,
    RunEnded,
    StreamOpened,
)
from arramon_server.sim.cameras import Frame
from arramon_server.sim.view import visible_pose


class EventSender:
    """Encodes the events of one stream and queues them as responses (`runs.play.transport.Transport`).

    Args:
        encoder: encodes images.
        image_sensors: names of the run's sensors that are images.
        image_size: side length of the images, in pixels.
        threads: in which images are compressed.
    """

    def __init__(
        self, encoder: ImageEncoder, image_sensors: Iterable[str], image_size: int, threads: ImageThreads
    ) -> None:
        self._outbox: asyncio.Queue[bytes | ArraMonError | None] = asyncio.Queue()
        self._backlog = 0
        self._encoder = encoder
        self._image_sensors = tuple(image_sensors)
        self._image_size = image_size
        self._threads = threads

    @property
    def compresses(self) -> bool:
        """Whether frames are compressed in threads."""
        return self._encoder.compresses

    @property
    def backlog(self) -> int:
        """Number of bytes of responses that have not left the server."""
        return self._backlog

    def canvas(self, episode_id: str) -> Frame | None:
        """Return the frame into which an episode's latest observation is drawn; None for a new frame."""
        return self._encoder.canvas(episode_id)

    def begin_encoding(self, event: Observed) -> Encoding:
        """Begin to compress an observation's images in the threads."""
        assert event.frame is not None
        return self._threads.begin(self._encoding(event, event.frame))

    def send(self, events: Sequence[Event]) -> None:
        """Queue a response with these events."""
        response = response_of([self._event(event) for event in events])
        self._backlog += len(response)
        self._outbox.put_nowait(response)

    def close(self, error: ArraMonError | None) -> None:
        """Queue the end of the stream."""
        self._outbox.put_nowait(error)

    async def next_response(self) -> bytes | None:
        """Return the next response in its wire format, and None at the end of the stream.

        Raises:
            ArraMonError: the error that closed the stream.
        """
        response = await self._outbox.get()
        if isinstance(response, ArraMonError):
            raise response
        return response

    def note_sent(self, response: bytes) -> None:
        """Take a response that has left the server off the backlog."""
        self._backlog -= len(response)

    def _event(self, event: Event) -> Parts:
        """Return an event in its wire format."""
        if isinstance(event, Observed):
            return self._observation(event)
        message = pb.Event()
        self._write(event, message)
        return [message.SerializeToString()]

    def _write(self, event: Event, message: pb.Event) -> None:
        match event:
            case EpisodeStarted():
                message.episode_started.CopyFrom(self._started(event))
            case PhaseFinished(episode_id, phase):
                over = message.phase_ended
                over.episode_id, over.turn, over.forced = episode_id, phase.turn, phase.forced
                over.phase = PHASES[phase.phase]
            case EpisodeEnded(episode_id, cause, ended):
                end = message.episode_ended
                end.episode_id, end.episodes_ended = episode_id, ended
                end.cause = types_pb2.Cause.Value(f"CAUSE_{cause}")
                self._encoder.forget(episode_id)
            case StreamOpened(run, progress, episode_ids):
                opened = message.opened
                opened.run.CopyFrom(run_message(run, progress))
                opened.episode_ids.extend(episode_ids)
                self._encoder.announce(opened)
                opened.image_size = self._image_size
                if "segmentation" in run.sensors:
                    opened.labels.extend(LABEL_MESSAGES)
            case ActionProblem(code, text, episode_id, step):
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
        if event.taken_note is not None:
            message.taken_note = event.taken_note
        if event.time_left is not None:
            message.step_seconds_left = event.time_left.step_seconds
            message.bank_seconds_left = event.time_left.bank_seconds
        if "pose" in sensors:
            message.pose.CopyFrom(pose_message(visible_pose(state)))
        if event.frame is None:
            return observation_event(message, ())
        images = (event.encoding or self._encoding(event, event.frame))()
        return observation_event(message, images)

    def _encoding(self, event: Observed, frame: Frame) -> Encoding:
        """Return the encoding of an observation's images, which has not begun."""
        images = [(getattr(frame, name), types_pb2.Image()) for name in self._image_sensors]

        def encode() -> list[EncodedImage]:
            data = self._encoder.encode(event.episode.episode_id, images, latest=event.taken is None)
            heads = [image for _, image in images]
            return list(zip(self._image_sensors, heads, data, strict=True))

        return encode

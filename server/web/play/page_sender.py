"""The transport of one play page: the engine's events as JSON, and each frame as one binary JPEG."""

import asyncio
import json
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import simplejpeg

from arramon_client.world import Action
from arramon_server.errors import ArraMonError, Conflict, Unavailable, quoted
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
from arramon_server.runs.play.stream import MAX_BACKLOG
from arramon_server.runs.storage.records import Run
from arramon_server.sim.cameras import Frame
from arramon_server.sim.geometry import wrap
from arramon_server.sim.rules import Phase, State
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.play.aids import Aids
from arramon_server.web.play.outcomes import outcome_of
from arramon_server.web.play.person_state import person_state

JPEG_QUALITY = 90
"""JPEG quality of the frames, the default quality of agents' JPEG images."""

FRAME_HEADER = struct.Struct("<I")
"""Header of a binary message: the step of the frame, 32 bits, little-endian. The JPEG follows."""

LOOK = 1 << 31
"""Bit of the header that marks a view in another heading."""

FIRST_GUESS = 6
"""Pixels per byte of a frame, before the first one is compressed."""

Message = str | bytes


@dataclass(frozen=True, slots=True)
class _PendingFrame:
    """A frame that is being compressed.

    Attributes:
        header: the number before the JPEG.
        encoding: completes the compression.
        expected_bytes: size of the JPEG that the backlog assumes until it is known.
    """

    header: int
    encoding: Encoding
    expected_bytes: int


class PageSender:
    """Encodes the events of one stream for the play page, and queues them (`runs.play.transport.Transport`).

    Args:
        run: the run, whose aids decide what is sent.
        is_hidden: whether its split is hidden: the page then learns no more than an agent.
        image_size: side length of the frames, in pixels.
        threads: in which frames are compressed.
        actions_of: returns the actions of an open episode so far; empty for any other.
        texts: texts in the run's language.

    Attributes:
        has_run_end: whether the end of the run was queued.
    """

    def __init__(
        self,
        run: Run,
        threads: ImageThreads,
        *,
        is_hidden: bool,
        image_size: int,
        actions_of: Callable[[str], Sequence[Action]],
        texts: PageTexts,
    ) -> None:
        self._is_hidden = is_hidden
        self._size = image_size
        self._threads = threads
        self._aids = Aids.of_run(run)
        self._actions_of = actions_of
        self._texts = texts
        self._outbox: asyncio.Queue[Message | _PendingFrame | ArraMonError | None] = asyncio.Queue()
        self._backlog = 0
        self._frame_bytes = image_size * image_size // FIRST_GUESS
        self._states: dict[str, State] = {}
        self._outcomes: dict[str, str] = {}
        self._shown: Observed | None = None
        self.has_run_end = False

    @property
    def compresses(self) -> bool:
        """Whether frames are compressed in threads: always."""
        return True

    @property
    def backlog(self) -> int:
        """Number of bytes of messages that have not left the server."""
        return self._backlog

    def canvas(self, episode_id: str) -> Frame | None:  # noqa: ARG002, part of the contract
        """Return None: frames may be drawn anywhere."""
        return None

    def begin_encoding(self, event: Observed) -> Encoding:
        """Begin to compress an observation's frame in the threads."""
        assert event.frame is not None
        return self._threads.begin(partial(_jpeg, event.frame))

    def send(self, events: Sequence[Event]) -> None:
        """Queue a message for each event, and one more for each frame."""
        for event in events:
            if isinstance(event, Observed) and event.taken is not None:
                # History, which an agent needs that takes over from another player; a person needs only the present.
                self._states[event.episode.episode_id] = event.state
                continue
            self.put(self._message(event))
            if isinstance(event, Observed) and event.frame is not None:
                self._queue_frame(event.state.step, event.encoding or partial(_jpeg, event.frame))

    def put(self, message: dict[str, Any]) -> None:
        """Queue a message that is no event."""
        self._queue(json.dumps(message, ensure_ascii=False))

    def look(self, episode_id: str, step: int, degrees: int) -> None:
        """Draw and queue the view from the present state in another heading. Nothing else changes.

        Args:
            episode_id, step: the present state.
            degrees: angle between the person's heading and the view, clockwise.

        Raises:
            Conflict: if the run has no such aid, or the episode is in another state.
            Unavailable: if the page has not yet read what was sent before.
        """
        if not self._aids.look_around:
            raise Conflict("this run has no aid `look_around`")
        shown = self._shown
        if shown is None or (shown.episode.episode_id, shown.state.step) != (episode_id, step):
            now = "no episode" if shown is None else f"step {shown.state.step} of {shown.episode.episode_id!r}"
            raise Conflict(f"a view from step {step} of {quoted(episode_id)} was requested, expected {now}")
        if self._backlog > MAX_BACKLOG:
            raise Unavailable(f"{self._backlog} bytes wait to be read; read them before you look again")
        frame = shown.world.render(_turned(shown.state, degrees), self._size)
        self.put({"type": "look", "episode": episode_id, "step": step, "degrees": degrees})
        self._queue_frame(step | LOOK, self._threads.begin(partial(_jpeg, frame)))

    def close(self, error: ArraMonError | None) -> None:
        """Queue the end of the stream."""
        self._outbox.put_nowait(error)

    async def next_message(self) -> Message | None:
        """Return the next message; None at the end of the stream.

        Raises:
            ArraMonError: the error that closed the stream.
        """
        message = await self._outbox.get()
        if isinstance(message, ArraMonError):
            raise message
        if isinstance(message, _PendingFrame):
            (jpeg,) = await asyncio.to_thread(message.encoding)
            self._backlog += len(jpeg) - message.expected_bytes
            self._frame_bytes = len(jpeg)
            return FRAME_HEADER.pack(message.header) + bytes(jpeg)
        return message

    def note_sent(self, message: Message) -> None:
        """Take a message that has left the server off the backlog."""
        self._backlog -= len(message)

    def _queue_frame(self, header: int, encoding: Encoding) -> None:
        """Queue a frame that the threads still compress, so that the engine need not wait for it."""
        self._backlog += FRAME_HEADER.size + self._frame_bytes
        self._outbox.put_nowait(_PendingFrame(header, encoding, self._frame_bytes))

    def _queue(self, message: Message) -> None:
        self._backlog += len(message)
        self._outbox.put_nowait(message)

    def _message(self, event: Event) -> dict[str, Any]:
        match event:
            case Observed():
                return self._state(event)
            case EpisodeStarted():
                return {"type": "started", "episode": event.episode.episode_id, "step": event.step}
            case PhaseFinished(episode_id, phase):
                kind = {"phase": phase.phase.value, "turn": phase.turn, "forced": phase.forced}
                return {"type": "phase_ended", "episode": episode_id, **kind}
            case EpisodeEnded(episode_id, cause, ended):
                self._states.pop(episode_id, None)
                self._outcomes.pop(episode_id, None)
                self._shown = None
                return {"type": "episode_ended", "episode": episode_id, "cause": cause, "ended": ended}
            case StreamOpened(run, progress, _):
                return {
                    "type": "opened",
                    "run": run.run_id,
                    "split": run.split,
                    "language": run.language,
                    "is_hidden": self._is_hidden,
                    "participant": run.participant,
                    "size": self._size,
                    "aids": self._aids.named(),
                    "episodes": progress.episodes,
                    "ended": progress.ended,
                    "has_clocks": run.step_seconds > 0,
                }
            case ActionProblem(code, text, episode_id, step):
                return {"type": "problem", "code": code, "message": text, "episode": episode_id, "step": step}
            case RunEnded(run, progress):
                self.has_run_end = True
                return {"type": "run_ended", "run": run.run_id, "state": run.state, "ended": progress.ended}

    def _state(self, event: Observed) -> dict[str, Any]:
        self._shown = event
        actions = self._actions_of(event.episode.episode_id)[: event.state.step]
        return person_state(
            event,
            self._aids,
            actions,
            self._outcome(event.episode.episode_id, event.state, actions),
            texts=self._texts,
            is_hidden=self._is_hidden,
        )

    def _outcome(self, episode_id: str, state: State, actions: Sequence[Action]) -> str:
        """Return what the last action did: the same for a state that is sent again; empty if that is not known."""
        before = self._states.get(episode_id)
        if before is None or before.step != state.step:
            known = before is not None and before.step == state.step - 1 and len(actions) == state.step
            self._outcomes[episode_id] = outcome_of(before, state, actions[-1]).value if before and known else ""
        self._states[episode_id] = state
        return self._outcomes[episode_id]


def _turned(state: State, degrees: int) -> State:
    """Return a state in another heading."""
    if state.phase is Phase.ASSEMBLY:
        return replace(state, room_heading=wrap(state.room_heading + degrees))
    return replace(state, pose=state.pose.turned(degrees))


def _jpeg(frame: Frame) -> list[bytes]:
    pixels = np.ascontiguousarray(frame.rgb)
    return [simplejpeg.encode_jpeg(pixels, quality=JPEG_QUALITY, colorspace="RGB", colorsubsampling="420")]

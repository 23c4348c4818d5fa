"""Delivery of events to streams: draws the frames of observations in threads, and gives events to the transport."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

from arramon_server.errors import ArraMonError, Unavailable
from arramon_server.image_threads import ImageThreads
from arramon_server.runs.play.events import (
    ActionProblem,
    EpisodeEnded,
    EpisodeStarted,
    Event,
    Observed,
    PhaseFinished,
    RunEnded,
)
from arramon_server.runs.play.faults import EpisodeFault, fault_boundary
from arramon_server.runs.play.stream import Stream
from arramon_server.runs.storage.meter import NO_METER, Meter, Stage
from arramon_server.runs.storage.records import Claim

TURN_SECONDS, TURN_EVENTS = 0.008, 32
"""Limits of one stream's turn: time spent drawing, and number of events."""

GROUP_EVENTS = 8
"""Maximum number of events drawn at once, between two checks of the time."""


def is_deliverable(stream: Stream) -> bool:
    """Return whether a stream has queued events and its client reads fast enough to get more."""
    return bool(stream.outbox) and not stream.is_congested


@dataclass(slots=True)
class DeliveryResult:
    """Result of one stream's turn.

    Attributes:
        run_ended: whether the end of the run was delivered.
        faulty: claims of the episodes that the server failed to draw or to encode.
        error: error with which the stream must be closed; None if it continues.
    """

    run_ended: bool = False
    faulty: list[Claim] = field(default_factory=list)
    error: ArraMonError | None = None


class Delivery:
    """Draws and delivers the queued events of one stream at a time.

    Args:
        threads: threads in which frames are drawn.
        now: returns the time of play, in seconds.
        meter: receives the time of each stage.
    """

    def __init__(self, threads: ImageThreads, now: Callable[[], float], meter: Meter = NO_METER) -> None:
        self._threads = threads
        self._now = now
        self._meter = meter

    def deliver(self, stream: Stream) -> DeliveryResult:
        """Deliver a stream's next events, within the limits of one turn."""
        done = DeliveryResult()
        if not is_deliverable(stream):
            return done
        events: list[Event] = []
        left, until = stream.max_latest_per_delivery, time.perf_counter() + TURN_SECONDS
        while stream.outbox and left and len(events) < TURN_EVENTS and (not events or time.perf_counter() < until):
            group = _next_group(stream, left)
            left -= sum(_is_latest(event) for event in group)
            events.extend(self._drawn(stream, group, done))
        self._send(stream, events, done)
        done.run_ended = any(isinstance(event, RunEnded) for event in events)
        return done

    def _drawn(self, stream: Stream, events: Sequence[Event], done: DeliveryResult) -> list[Event]:
        """Return the events, with frames if the run's sensors include images, and without those that failed."""
        if not stream.wants_images:
            return list(events)
        works = [partial(self._draw, stream, event) for event in events]
        # Threads draw, unless they have frames to compress.
        results = [work() for work in works] if stream.transport.compresses else self._threads.run(works)
        drawn: list[Event] = []
        for result in results:
            if isinstance(result, EpisodeFault):
                done.faulty.append(result.claim)
            else:
                drawn.append(result)
        return drawn

    def _draw(self, stream: Stream, event: Event) -> Event | EpisodeFault:
        """Draw the frame of an observation; return the event, or the fault of its episode. Thread-safe."""
        if not isinstance(event, Observed):
            return event
        started = time.perf_counter()
        try:
            with fault_boundary(stream.run, stream.claim_of(event.episode.episode_id), "drawing"):
                frame = event.world.render(
                    event.state,
                    stream.image_size,
                    segmentation="segmentation" in stream.run.sensors,
                    into=stream.transport.canvas(event.episode.episode_id) if event.taken is None else None,
                )
                drawn = event.with_images(frame)
                self._meter.record_duration(Stage.DRAW, time.perf_counter() - started)
                if stream.transport.compresses:
                    drawn = event.with_images(frame, stream.transport.begin_encoding(drawn))
        except EpisodeFault as fault:
            return fault
        return drawn

    def _send(self, stream: Stream, events: Sequence[Event], done: DeliveryResult) -> None:
        """Send events; if that fails, send them one at a time, so that a faulty one does not block the others."""
        if not events:
            return
        claim, started = stream.claim_of(_episode_id(events[0])), time.perf_counter()
        try:
            with fault_boundary(stream.run, claim, "delivering"):
                stream.transport.send(events)
            self._meter.record_duration(Stage.ENCODE, time.perf_counter() - started)
        except EpisodeFault:
            if len(events) > 1:
                for event in events:
                    self._send(stream, [event], done)
            elif claim.episode_id:
                done.faulty.append(claim)
            else:
                done.error = Unavailable("the server could not continue this stream; nothing is lost, reconnect")
            return
        now = self._now()
        sent = [
            (event.episode.episode_id, event.state.step)
            for event in events
            if isinstance(event, Observed) and event.taken is None
        ]
        for episode_id, step in sent:
            if episode_id in stream.sessions:
                stream.sessions[episode_id].thinking.send(step, now)
        if stream.clock is not None:
            stream.clock.send(sent)


def _episode_id(event: Event) -> str:
    """Return the id of the episode that an event belongs to; empty for events of the whole stream."""
    match event:
        case Observed() | EpisodeStarted():
            return event.episode.episode_id
        case PhaseFinished() | EpisodeEnded() | ActionProblem():
            return event.episode_id
        case _:
            return ""


def _next_group(stream: Stream, latest: int) -> list[Event]:
    """Remove and return a stream's next events that can be drawn at once: at most one observation per episode.

    Args:
        stream: the stream.
        latest: maximum number of events that are the latest observation of their episode.
    """
    group: list[Event] = []
    drawn: set[str] = set()
    while stream.outbox and len(group) < GROUP_EVENTS:
        event = stream.outbox[0]
        if isinstance(event, Observed):
            if event.episode.episode_id in drawn or (_is_latest(event) and not latest):
                break
            drawn.add(event.episode.episode_id)
            latest -= _is_latest(event)
        group.append(stream.outbox.popleft())
    return group


def _is_latest(event: Event) -> bool:
    return isinstance(event, Observed) and event.taken is None

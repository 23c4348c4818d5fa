"""What streams are told: draws it, and delivers it, one stream after the other."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from server.errors import ArraMonError, Unavailable
from server.runs.events import EpisodeEnded, EpisodeStarted, Event, Observed, PhaseOver, Problem, RunEnded
from server.runs.faults import EpisodeFault, contained
from server.runs.meter import NO_METER, Meter, Stage
from server.runs.records import Claim
from server.runs.stream import Stream
from server.runs.worlds import Worlds

TURN_SECONDS, TURN_EVENTS = 0.004, 16
"""A stream's turn: so long it is drawn for, and so many events it is told at the most, before the next one's turn."""

MAX_BACKLOG = 2 << 20
"""Bytes waiting to leave, from which on a slow reader gets nothing more drawn: eight raw observations or so."""


def can_be_told(stream: Stream) -> bool:
    """Whether a stream is to be told something, and reads what it was told."""
    return bool(stream.told) and stream.backlog() < MAX_BACKLOG


class Delivering:
    """Delivers.

    Args:
        worlds: draw.
        take: takes an episode from its stream, over which the server broke down.
        drop: ends a stream with an error.
        meter: is told how long it takes.
    """

    def __init__(
        self,
        worlds: Worlds,
        take: Callable[[Stream, Claim], None],
        drop: Callable[[Stream, ArraMonError], None],
        meter: Meter = NO_METER,
    ) -> None:
        self._meter = meter
        self._worlds = worlds
        self._take = take
        self._drop = drop

    def turn(self, stream: Stream) -> bool:
        """Gives a stream its turn; returns whether it was told that its run has ended."""
        if not can_be_told(stream):
            return False
        events: list[Event] = []
        until = time.perf_counter() + TURN_SECONDS
        while stream.told and len(events) < TURN_EVENTS and (not events or time.perf_counter() < until):
            event = stream.told.popleft()
            try:
                events.append(self._drawn(stream, event))
            except EpisodeFault as fault:
                self._take(stream, fault.claim)
        self._send(stream, events)
        return any(isinstance(event, RunEnded) for event in events)

    def _drawn(self, stream: Stream, event: Event) -> Event:
        if not (isinstance(event, Observed) and stream.sees):
            return event
        started = time.perf_counter()
        with contained(stream.run, stream.claim_of(event.episode.episode_id), "drawing"):
            frame = self._worlds.render(
                stream.run.split,
                event.episode,
                event.state,
                stream.image_size,
                segmentation="segmentation" in stream.run.sensors,
            )
        self._meter.took(Stage.DRAW, time.perf_counter() - started)
        return replace(event, frame=frame)

    def _send(self, stream: Stream, events: Sequence[Event]) -> None:
        """Delivers events; one that cannot be written is kept from taking the others with it."""
        if not events:
            return
        claim, started = stream.claim_of(_episode_id(events[0])), time.perf_counter()
        try:
            with contained(stream.run, claim, "delivering"):
                stream.deliver(events)
            self._meter.took(Stage.ENCODE, time.perf_counter() - started)
        except EpisodeFault:
            if len(events) > 1:
                for event in events:
                    self._send(stream, [event])
            elif claim.episode_id:
                self._take(stream, claim)
            else:
                self._drop(stream, Unavailable("the server could not go on with this stream; nothing is lost"))
            return
        if stream.clock is not None:
            stream.clock.send(
                (event.episode.episode_id, event.state.step)
                for event in events
                if isinstance(event, Observed) and event.taken is None
            )


def _episode_id(event: Event) -> str:
    """Whose an event is; empty for those of the stream."""
    match event:
        case Observed() | EpisodeStarted():
            return event.episode.episode_id
        case PhaseOver() | EpisodeEnded() | Problem():
            return event.episode_id
        case _:
            return ""

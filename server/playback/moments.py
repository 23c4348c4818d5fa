"""A recorded episode as a list of moments: state, action, the rules' answer, and what stands out. Pure, but for the
collision check."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from arramon_client.world import EYE_HEIGHT, Action, turn_between
from arramon_server.episodes.episode import Episode, Turn
from arramon_server.scoring.running_ndtw import RunningNdtw
from arramon_server.scoring.trajectory import Point2
from arramon_server.scoring.turn_outcomes import MAX_DEVIATION
from arramon_server.sim import rules
from arramon_server.sim.rules import (
    Blocked,
    CollisionCheck,
    Event,
    Limits,
    Moved,
    Phase,
    PhaseEnded,
    PickedUp,
    Placed,
    State,
)

ABOUT = 150.0
"""Angle between the headings of two moves from which the agent has turned about, in degrees."""


class MomentMark(StrEnum):
    """What stands out in a moment."""

    LEFT = "left"
    """The agent has come further than MAX_DEVIATION from the reference path."""
    BACK = "back"
    """It is near the reference path again."""
    BLOCKED = "blocked"
    """Its action is blocked."""
    ABOUT = "about"
    """Its move leads back: it has turned by ABOUT or more since its last move."""
    PICKED_UP = "picked_up"
    PLACED = "placed"
    FORCED = "forced"
    """A limit ends a phase."""


@dataclass(frozen=True, slots=True)
class Moment:
    """One step of an episode.

    Attributes:
        state: the state in which the agent acts; `state.step` numbers the moment, from 0.
        action: its action; None in the last moment, after which nothing is recorded.
        events: the rules' answer to the action; in the last moment those of the time limit, if it ended the episode.
        distance: in the city from the agent to its target, in units and three dimensions, as in CTC; in the room the
            number of columns and rows from its cell to the target's.
        ndtw: nDTW of the turn's path so far.
        marks: what stands out.
    """

    state: State
    action: Action | None
    events: tuple[Event, ...]
    distance: float
    ndtw: float
    marks: tuple[MomentMark, ...] = ()


class Playback:
    """The moments of a recorded episode, which may still be played: it grows with its actions.

    Args:
        episode: the episode.
        collisions: collision check of its scene.
        limits: limits of its run.
    """

    def __init__(self, episode: Episode, collisions: CollisionCheck, limits: Limits) -> None:
        self.episode = episode
        self._collisions = collisions
        self._limits = limits
        self._turn = _TurnProgress(1, episode.turns[0])
        self._past: list[Moment] = []
        self._latest = self._at(rules.begin(episode.layout))

    @property
    def moments(self) -> Sequence[Moment]:
        """The moments so far: one for each action, and a last one without action."""
        return [*self._past, self._latest]

    @property
    def steps(self) -> int:
        """Number of recorded actions."""
        return len(self._past)

    @property
    def is_finished(self) -> bool:
        """Whether the episode takes no more actions."""
        return self._latest.state.finished

    def moment(self, step: int) -> Moment:
        """Return a moment.

        Raises:
            IndexError: if there is none of that number.
        """
        if not 0 <= step <= len(self._past):
            raise IndexError(f"there is no step {step}; expected 0 to {len(self._past)}")
        return self._latest if step == len(self._past) else self._past[step]

    def extend(self, actions: Iterable[int]) -> None:
        """Apply further recorded actions.

        Raises:
            ValueError: if the episode is finished.
        """
        for number in actions:
            before, action = self._latest.state, Action(number)
            after, events = rules.step(before, action, self.episode.layout, self._collisions, self._limits)
            marks = (*self._latest.marks, *_marks_of(events))
            if self._turn.turns_about(before, events):
                marks += (MomentMark.ABOUT,)
            self._past.append(replace(self._latest, action=action, events=events, marks=marks))
            self._latest = self._at(after)

    def end_at_time_limit(self) -> None:
        """Add the answer of the rules to a time limit, which ended the episode, to the last moment.

        Raises:
            ValueError: if the episode is finished.
        """
        _, events = rules.time_out(self._latest.state, self.episode.layout)
        self._latest = replace(self._latest, events=events, marks=(*self._latest.marks, *_marks_of(events)))

    def _at(self, state: State) -> Moment:
        if state.turn != self._turn.number:
            self._turn = _TurnProgress(state.turn, self.episode.turns[state.turn - 1])
        if state.phase is Phase.ASSEMBLY:
            cell = self._turn.truth.target_cell
            distance = float(abs(state.square.column - cell.column) + abs(state.square.row - cell.row))
            return Moment(state, None, (), distance, self._turn.ndtw.value)
        marks = self._turn.walk_to((state.pose.x, state.pose.z))
        distance = math.dist((state.pose.x, EYE_HEIGHT, state.pose.z), self._turn.truth.target.position)
        return Moment(state, None, (), distance, self._turn.ndtw.value, marks)


class _TurnProgress:
    """What is known of a turn's path so far.

    Args:
        number: 1 or 2.
        truth: the turn's ground truth.
    """

    def __init__(self, number: int, truth: Turn) -> None:
        self.number = number
        self.truth = truth
        self.ndtw = RunningNdtw(truth.path)
        self._reference = np.array(truth.path, dtype=np.float64)
        self._is_off = False
        self._place: Point2 | None = None
        self._heading: float | None = None

    def walk_to(self, place: Point2) -> tuple[MomentMark, ...]:
        """Extend the path; return LEFT or BACK if it has left the reference or is back."""
        if place == self._place:
            return ()
        self._place = place
        self.ndtw.add(place)
        was_off, self._is_off = self._is_off, distance_to_path(self._reference, place) > MAX_DEVIATION
        if was_off == self._is_off:
            return ()
        return (MomentMark.LEFT,) if self._is_off else (MomentMark.BACK,)

    def turns_about(self, before: State, events: Sequence[Event]) -> bool:
        """Return whether a step in the street moves back, and remember its heading if it moves."""
        if before.phase is not Phase.NAVIGATION or not any(isinstance(event, Moved) for event in events):
            return False
        last, self._heading = self._heading, before.pose.heading
        return last is not None and abs(turn_between(last, before.pose.heading)) >= ABOUT


def distance_to_path(path: "np.typing.NDArray[np.float64]", place: Point2) -> float:
    """Return the distance from a place to the nearest point of a path (n, 2), in units."""
    here = np.array(place)
    if len(path) == 1:
        return float(np.hypot(*(path[0] - here)))
    starts, along = path[:-1], np.diff(path, axis=0)
    lengths = np.maximum((along**2).sum(axis=1), 1e-12)
    shares = np.clip(((here - starts) * along).sum(axis=1) / lengths, 0.0, 1.0)
    return float(np.hypot(*(starts + shares[:, None] * along - here).T).min())


def _marks_of(events: Sequence[Event]) -> tuple[MomentMark, ...]:
    found = list[MomentMark]()
    for event in events:
        match event:
            case Blocked():
                found.append(MomentMark.BLOCKED)
            case PickedUp():
                found.append(MomentMark.PICKED_UP)
            case Placed():
                found.append(MomentMark.PLACED)
            case PhaseEnded(forced=True):
                found.append(MomentMark.FORCED)
    return tuple(dict.fromkeys(found))

"""The rules of the task: pure functions `(state, action) -> state, events`, apart from a `CollisionCheck`.

Kinematics, pick-up box, room and fallbacks are those of the paper (sections 3 and 4, appendix D) and of its release, as
measured. In the room, walls block the agent and objects do not: in 139 of val-seen's 1,065 second turns, the ground
truth leads through the cell in which the first turn's object was placed. Each turn has its own objects in the street:
an error in turn 1 changes the start of turn 2, as in the paper, but never its target.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Protocol

import arramon_client.world as world
from arramon_client.world import REACH_AHEAD, REACH_MARGIN, REACH_SIDE, STEP, STEPS_PER_PHASE, TURN, TURNS, Action
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Point, Pose, wrap
from arramon_server.sim.room import START, RoomCell, RoomPosition


class Phase(Enum):
    """The two halves of a turn."""

    NAVIGATION = world.NAVIGATION
    ASSEMBLY = world.ASSEMBLY


class CollisionCheck(Protocol):
    """The collision check of a section that the rules use.

    The agent is a disc of AGENT_RADIUS that moves straight, and each solid body a rectangle. A body blocks the way if
    its distance from the straight line between the two places is at most AGENT_RADIUS. Where it differs from that by at
    most `footprints.TOUCHING`, the exact distance decides (`footprints.Footprint.distance`). Elsewhere a physics engine
    may decide (`bullet.Obstacles`), as it agrees with the distance there. So all implementations give equal answers.
    """

    def way_is_free(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        """Return whether the agent can move straight from one (x, z) to another."""
        ...


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a run.

    Attributes:
        steps_per_phase: steps in each phase of each turn.
    """

    steps_per_phase: int = STEPS_PER_PHASE


@dataclass(frozen=True, slots=True)
class Collectible:
    """An object in the street at the beginning of a turn.

    Attributes:
        type: its appearance.
        position: its centre, in the world frame.
    """

    type: ObjectType
    position: Point


@dataclass(frozen=True, slots=True)
class PlacedObject:
    """An object in the room."""

    type: ObjectType
    placement: RoomPosition


@dataclass(frozen=True, slots=True)
class EpisodeLayout:
    """The initial layout of an episode: start pose and objects.

    Attributes:
        start: pose at the beginning of turn 1.
        streets: objects in the street, by turn; the first one is the target.
        decoys: objects in the room when the first assembly begins.
    """

    start: Pose
    streets: tuple[tuple[Collectible, ...], ...]
    decoys: tuple[PlacedObject, ...]


@dataclass(frozen=True, slots=True)
class State:
    """The state of an episode.

    Attributes:
        turn: 1 or 2.
        step: steps taken in the episode.
        phase_step: steps taken in the current phase.
        pose: pose in the city; unchanged while the agent is in the room, as turn 2 continues from there.
        square, room_heading: pose in the room; the start tile while the agent is in the city.
        carried: the object picked up in this turn, None before that.
        room: all objects in the room.
        finished: whether the episode takes no more actions.
    """

    pose: Pose
    room: tuple[PlacedObject, ...]
    turn: int = 1
    phase: Phase = Phase.NAVIGATION
    step: int = 0
    phase_step: int = 0
    square: RoomCell = START
    room_heading: float = 0.0
    carried: ObjectType | None = None
    finished: bool = False


@dataclass(frozen=True, slots=True)
class Moved:
    """The agent changed its position."""


@dataclass(frozen=True, slots=True)
class Blocked:
    """A solid body, the room's wall or an oblique heading in the room prevented a movement."""


@dataclass(frozen=True, slots=True)
class PickedUp:
    """An object was picked up.

    Attributes:
        index: its index in the turn's `EpisodeLayout.streets`; 0 is the target.
    """

    index: int


@dataclass(frozen=True, slots=True)
class Placed:
    """The object carried was placed in the room."""

    placement: RoomPosition


@dataclass(frozen=True, slots=True)
class PhaseEnded:
    """A phase ended.

    Attributes:
        forced: whether the step limit or a clock ended it.
    """

    turn: int
    phase: Phase
    forced: bool


Event = Moved | Blocked | PickedUp | Placed | PhaseEnded
Outcome = tuple[State, tuple[Event, ...]]


def begin(layout: EpisodeLayout) -> State:
    """Return the state before the first step."""
    return State(pose=layout.start, room=layout.decoys)


def step(state: State, action: Action, layout: EpisodeLayout, collisions: CollisionCheck, limits: Limits) -> Outcome:
    """Apply one action.

    Args:
        state: the state before.
        action: the agent's action.
        layout: the episode's objects.
        collisions: checks collisions in the section.
        limits: the action of the step that reaches a limit is applied; if it does not end the phase, the rules do.

    Returns:
        The state after, and the events, in order.

    Raises:
        ValueError: if the episode is finished.
    """
    if state.finished:
        raise ValueError("the episode is finished; it takes no more steps")
    phase = state.phase
    state = _changed(state, step=state.step + 1, phase_step=state.phase_step + 1)
    act = _act_in_city if phase is Phase.NAVIGATION else _act_in_room
    state, events = act(state, action, layout, collisions)
    if state.phase is phase and not state.finished and state.phase_step >= limits.steps_per_phase:
        state, forced = _force(state, layout)
        events += forced
    return state, events


def time_out(state: State, layout: EpisodeLayout) -> Outcome:
    """End an episode at its time limit: the current phase and all later ones end as at their step limit.

    This counts no step.

    Raises:
        ValueError: if the episode is finished.
    """
    if state.finished:
        raise ValueError("the episode is finished; its time cannot run out")
    happened: tuple[Event, ...] = ()
    while not state.finished:
        state, events = _force(state, layout)
        happened += events
    return state, happened


def reachable(pose: Pose, street: Sequence[Collectible]) -> int | None:
    """Return the index of the object that a pick-up at `pose` takes: the nearest in the pick-up box, or None.

    An object is in the box if its centre is, within REACH_MARGIN.
    """
    found = []
    for index, item in enumerate(street):
        right, ahead = pose.local(item.position.x, item.position.z)
        if abs(right) <= REACH_SIDE + REACH_MARGIN and 0.0 <= ahead <= REACH_AHEAD + REACH_MARGIN:
            found.append((right * right + ahead * ahead, index))
    return min(found)[1] if found else None


def height_at(room: Sequence[PlacedObject], square: RoomCell) -> int:
    """Return the number of objects stacked on a cell."""
    return sum((item.placement.column, item.placement.row) == square for item in room)


def moved(pose: Pose, action: Action) -> Pose:
    """Return the pose after an action in the city, without a collision check."""
    return pose.ahead(STEP) if action is Action.FORWARD else pose.turned(_turn(action))


def _turn(action: Action) -> float:
    return {Action.LEFT: -TURN, Action.RIGHT: TURN}.get(action, 0.0)


def _changed(
    state: State,
    *,
    pose: Pose | None = None,
    step: int | None = None,
    phase_step: int | None = None,
    square: RoomCell | None = None,
    room_heading: float | None = None,
) -> State:
    """Return a state with some attributes changed, like `replace` but four times as fast."""
    return State(
        state.pose if pose is None else pose,
        state.room,
        state.turn,
        state.phase,
        state.step if step is None else step,
        state.phase_step if phase_step is None else phase_step,
        state.square if square is None else square,
        state.room_heading if room_heading is None else room_heading,
        state.carried,
        state.finished,
    )


def _act_in_city(state: State, action: Action, layout: EpisodeLayout, collisions: CollisionCheck) -> Outcome:
    if action is Action.INTERACT:
        index = reachable(state.pose, layout.streets[state.turn - 1])
        return (state, ()) if index is None else _pick_up(state, layout, index, forced=False)
    after = moved(state.pose, action)
    if action is not Action.FORWARD:
        return _changed(state, pose=after), ()
    if not collisions.way_is_free((state.pose.x, state.pose.z), (after.x, after.z)):
        return state, (Blocked(),)
    return _changed(state, pose=after), (Moved(),)


def _act_in_room(state: State, action: Action, layout: EpisodeLayout, collisions: CollisionCheck) -> Outcome:  # noqa: ARG001 (as in the city)
    if action in (Action.LEFT, Action.RIGHT):
        return _changed(state, room_heading=wrap(state.room_heading + _turn(action))), ()
    ahead = _square_ahead(state)
    if action is Action.INTERACT:
        return (state, ()) if ahead is None else _place(state, ahead, forced=False)
    if ahead is None:
        return state, (Blocked(),)
    return _changed(state, square=ahead), (Moved(),)


def _square_ahead(state: State) -> RoomCell | None:
    """Return the cell ahead; None at an oblique heading or towards a wall."""
    if state.room_heading % 90.0:
        return None
    ahead = state.square.ahead(state.room_heading)
    return ahead if ahead.is_inside() else None


def _force(state: State, layout: EpisodeLayout) -> Outcome:
    """Force the end of a phase, as at its step limit (paper, appendix D.1)."""
    if state.phase is Phase.ASSEMBLY:
        return _place(state, _square_ahead(state) or state.square, forced=True)

    def distance(index: int) -> float:
        position = layout.streets[state.turn - 1][index].position
        return (position.x - state.pose.x) ** 2 + (position.z - state.pose.z) ** 2

    nearest = min(range(len(layout.streets[state.turn - 1])), key=distance)
    return _pick_up(state, layout, nearest, forced=True)


def _pick_up(state: State, layout: EpisodeLayout, index: int, *, forced: bool) -> Outcome:
    after = replace(
        state,
        phase=Phase.ASSEMBLY,
        phase_step=0,
        square=START,
        room_heading=0.0,
        carried=layout.streets[state.turn - 1][index].type,
    )
    return after, (PickedUp(index), PhaseEnded(state.turn, Phase.NAVIGATION, forced))


def _place(state: State, square: RoomCell, *, forced: bool) -> Outcome:
    if state.carried is None:
        raise ValueError("nothing is carried in the assembly phase; the state was not made by these rules")
    placement = RoomPosition(square.column, height_at(state.room, square) + 1, square.row)
    last = state.turn == TURNS
    after = replace(
        state,
        turn=state.turn if last else state.turn + 1,
        phase=Phase.ASSEMBLY if last else Phase.NAVIGATION,
        phase_step=state.phase_step if last else 0,
        carried=None,
        room=(*state.room, PlacedObject(state.carried, placement)),
        finished=last,
    )
    return after, (Placed(placement), PhaseEnded(state.turn, Phase.ASSEMBLY, forced))

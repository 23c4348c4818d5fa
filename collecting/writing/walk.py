"""How a writer walks: along the ground truth's line in the street, freely in the room.

Pure functions of position and move.

The writer cannot leave the line. In the room, the object lands on its ground-truth cell wherever the writer puts it, so
that turn 2 and later texts stay valid (paper, appendix "Instruction Rules and Guidelines").
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from arramon_client.world import HEADINGS, PHASES, TURN, TURNS, Action, bearing
from arramon_server.episodes.episode import Episode
from arramon_server.errors import BadInput, quoted
from arramon_server.sim.geometry import Pose, wrap
from arramon_server.sim.room import START, RoomCell
from arramon_server.sim.rules import Phase, PlacedObject, State

PARTS = tuple((turn, phase) for turn in range(1, TURNS + 1) for phase in PHASES)
"""The parts of a task, in order: (turn, phase). Each has one text."""

DONE = len(PARTS)
"""`Position.reached` of a writer who has been through all parts."""

_TURNS = {"left": -1, "right": 1}


class Move(StrEnum):
    """What a writer can do."""

    FORWARD = "forward"
    BACK = "back"
    LEFT = "left"
    RIGHT = "right"
    ACT = "act"
    """Pick up or place the object."""


class Outcome(StrEnum):
    """What a move did; the page has a sentence for each."""

    MOVED = "moved"
    TURNED = "turned"
    FACED_LINE = "faced_line"
    AT_START = "at_start"
    AT_TARGET = "at_target"
    NOT_THERE_YET = "not_there_yet"
    PICKED_UP = "picked_up"
    BLOCKED = "blocked"
    CANNOT_PLACE = "cannot_place"
    PLACED = "placed"
    FINISHED = "finished"


@dataclass(frozen=True, slots=True)
class Position:
    """Where a writer is. It is not secret: the page holds it, and sends it with each move.

    Attributes:
        part: index in PARTS.
        place: index of the place on the line; in the room 0, and 1 after the last object was placed.
        turned: heading in turns of 30 degrees clockwise, 0 to 11: in the street from the episode's start heading, in
            the room from +row.
        cell: the cell in the room; the start tile in the street.
        reached: the last part that the writer has been to, or DONE.
    """

    part: int
    place: int
    turned: int
    cell: RoomCell
    reached: int

    @property
    def is_indoors(self) -> bool:
        """Whether the writer is in the room."""
        return PARTS[self.part][1] == Phase.ASSEMBLY.value

    @property
    def is_placed(self) -> bool:
        """Whether the last object was placed, and the writer sees it at its place."""
        return self.is_indoors and self.place == 1

    @property
    def turn(self) -> int:
        """The turn, 1 or 2."""
        return PARTS[self.part][0]

    def __str__(self) -> str:
        return ".".join(map(str, (self.part, self.place, self.turned, *self.cell, self.reached)))


@dataclass(frozen=True, slots=True)
class Line:
    """The line of one turn.

    Attributes:
        places: the ground truth's positions (x, z), in units.
        headings: by place, the heading in which the ground truth leaves it, in turns of 30 degrees from the episode's
            start heading; at the last place, that of the pick-up.
        arrival: the heading in which the turn begins, likewise.
    """

    places: tuple[tuple[float, float], ...]
    headings: tuple[int, ...]
    arrival: int


def lines(episode: Episode) -> tuple[Line, ...]:
    """Return the lines of both turns."""
    found: list[Line] = []
    turned = 0
    for turn in episode.turns:
        arrival = turned
        turned = (turned + _turns(turn.actions)) % HEADINGS
        leaving = [
            round(wrap(bearing(place, after) - episode.start.heading) / TURN) % HEADINGS
            for place, after in zip(turn.path, turn.path[1:], strict=False)
        ]
        found.append(Line(turn.path, (*leaving, turned), arrival))
    return tuple(found)


def begin(episode: Episode) -> Position:
    """Return the position at the start of the episode."""
    return _enter(0, lines(episode), 0)


def enter(position: Position, part: int, episode: Episode) -> Position:
    """Return the position at the start of a part that the writer has been to.

    Raises:
        BadInput: if the writer has not come so far.
    """
    if not 0 <= part <= min(position.reached, DONE - 1):
        raise BadInput(f"part {part} has not been reached; expected 0 to {min(position.reached, DONE - 1)}")
    return _enter(part, lines(episode), position.reached)


def moved(position: Position, move: Move, episode: Episode) -> tuple[Position, Outcome]:
    """Return the position after a move, and what the move did."""
    if move in _TURNS:
        return replace(position, turned=(position.turned + _TURNS[move]) % HEADINGS), Outcome.TURNED
    walk = _in_room if position.is_indoors else _on_line
    after, outcome = walk(position, move, lines(episode))
    return (_with_object(after, episode) if outcome is Outcome.FINISHED else after), outcome


def read_position(text: str, episode: Episode) -> Position:
    """Parse the text of a position (`str(position)`).

    Raises:
        BadInput: if it is none of this episode.
    """
    if not re.fullmatch(r"[0-9]{1,4}(\.[0-9]{1,4}){5}", text):
        raise BadInput(
            f"position {quoted(text)}; expected six whole numbers with dots between them, such as 0.0.0.2.0.0"
        )
    part, place, turned, column, row, reached = map(int, text.split("."))
    position = Position(part, place, turned, RoomCell(column, row), reached)
    if part >= DONE or not part <= reached <= DONE or turned >= HEADINGS or not position.cell.is_inside():
        raise BadInput(f"there is no position {quoted(text)}")
    is_done = position.part == DONE - 1 and reached == DONE
    last = int(is_done) if position.is_indoors else len(episode.turns[position.turn - 1].path) - 1
    if place > last:
        raise BadInput(f"position {quoted(text)} is beyond the end of the line, place {last}")
    return position


def preview(position: Position, episode: Episode) -> Position:
    """Return the position whose view is the preview of the turn's other phase (paper, appendix "Interface").

    In the street it is the start of the room; in the room, the place in the street from which the object was taken.
    """
    if position.is_indoors:
        line = lines(episode)[position.turn - 1]
        last = len(line.places) - 1
        return Position(position.part - 1, last, line.headings[last], START, position.reached)
    return Position(position.part + 1, 0, 0, START, position.reached)


def state_at(position: Position, episode: Episode) -> State:
    """Return the episode's state in which an agent would see what the writer sees, but for the guide."""
    line = lines(episode)[position.turn - 1]
    x, z = line.places[0 if position.is_indoors else position.place]
    pose = Pose(x, z, wrap(episode.start.heading + TURN * position.turned))
    room = room_before(episode, position.turn)
    if not position.is_indoors:
        return State(pose=pose, room=room, turn=position.turn)
    turn = episode.turns[position.turn - 1]
    placed = (PlacedObject(turn.target.type, turn.target_cell),) if position.is_placed else ()
    return State(
        pose=pose,
        room=(*room, *placed),
        turn=position.turn,
        phase=Phase.ASSEMBLY,
        square=position.cell,
        room_heading=wrap(TURN * position.turned),
        carried=None if placed else turn.target.type,
    )


def room_before(episode: Episode, turn: int) -> tuple[PlacedObject, ...]:
    """Return the objects in the room when the assembly of turn 1 or 2 begins, all where the ground truth has them."""
    earlier = episode.turns[: turn - 1]
    return (*episode.decoys, *(PlacedObject(each.target.type, each.target_cell) for each in earlier))


def target_bearing(position: Position, episode: Episode) -> float | None:
    """Return the direction of the target or its cell from the writer's view, in degrees in [0, 360), clockwise.

    None on the target's cell, and when all objects are placed.
    """
    turn = episode.turns[position.turn - 1]
    if position.is_placed:
        return None
    if position.is_indoors:
        goal = (turn.target_cell.column, turn.target_cell.row)
        if goal == position.cell:
            return None
        return wrap(bearing(position.cell, goal) - TURN * position.turned)
    pose = state_at(position, episode).pose
    return wrap(bearing((pose.x, pose.z), (turn.target.position.x, turn.target.position.z)) - pose.heading)


def _on_line(position: Position, move: Move, lines: Sequence[Line]) -> tuple[Position, Outcome]:
    line = lines[position.turn - 1]
    last = len(line.places) - 1
    if move is Move.ACT:
        if position.place < last:
            return position, Outcome.NOT_THERE_YET
        return _enter(position.part + 1, lines, max(position.reached, position.part + 1)), Outcome.PICKED_UP
    if move is Move.BACK:
        if position.place == 0:
            return replace(position, turned=line.arrival), Outcome.AT_START
        return _walked(position, line, position.place - 1), Outcome.MOVED
    ahead = line.headings[position.place]
    off = abs((ahead - position.turned + HEADINGS // 2) % HEADINGS - HEADINGS // 2)
    if off > 1 or (off and position.place == last):
        return replace(position, turned=ahead), Outcome.FACED_LINE
    if position.place == last:
        return position, Outcome.AT_TARGET
    # Paths zigzag by single turns: the writer goes with them, and turns on the spot only where the line really bends.
    return replace(position, place=position.place + 1, turned=ahead), Outcome.MOVED


def _walked(position: Position, line: Line, place: int) -> Position:
    return replace(position, place=place, turned=line.headings[place])


def _in_room(position: Position, move: Move, lines: Sequence[Line]) -> tuple[Position, Outcome]:
    heading = TURN * position.turned
    if heading % 90.0:
        return position, Outcome.CANNOT_PLACE if move is Move.ACT else Outcome.BLOCKED
    square = position.cell.ahead(heading if move is not Move.BACK else wrap(heading + 180.0))
    if not square.is_inside():
        return position, Outcome.CANNOT_PLACE if move is Move.ACT else Outcome.BLOCKED
    if move is not Move.ACT:
        return replace(position, cell=square), Outcome.MOVED
    if position.part == DONE - 1:
        return replace(position, reached=DONE), Outcome.FINISHED
    return _enter(position.part + 1, lines, max(position.reached, position.part + 1)), Outcome.PLACED


def _with_object(position: Position, episode: Episode) -> Position:
    """Return the position in which the writer sees the last object at its place, from the start tile if it is on it."""
    goal = episode.turns[position.turn - 1].target_cell
    at = RoomCell(goal.column, goal.row)
    cell = START if position.cell == at else position.cell
    return replace(position, place=1, cell=cell, turned=round(bearing(cell, at) / TURN) % HEADINGS)


def _enter(part: int, lines: Sequence[Line], reached: int) -> Position:
    turn, phase = PARTS[part]
    turned = 0 if phase == Phase.ASSEMBLY.value else lines[turn - 1].arrival
    return Position(part, 0, turned, START, reached)


def _turns(actions: Sequence[Action]) -> int:
    return sum({Action.LEFT: -1, Action.RIGHT: 1}.get(action, 0) for action in actions)

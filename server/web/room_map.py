"""Map of the assembly room from above, with its objects and the agent's path, for SVG."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from arramon_client.world import COLUMNS, ROWS
from arramon_server.episodes.episode import Turn
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.scoring.trajectory import TurnRecord
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.room import START, RoomCell
from arramon_server.sim.rules import Phase, PlacedObject

CELL = 10
"""Side of a cell, in the picture's units."""

WIDTH, HEIGHT = COLUMNS * CELL, ROWS * CELL


@dataclass(frozen=True, slots=True)
class ObjectStack:
    """Stack of objects on one cell.

    Attributes:
        x, y: centre of the cell.
        types: types of the objects, from the floor up.
    """

    x: float
    y: float
    types: tuple[ObjectType, ...]


@dataclass(frozen=True, slots=True)
class AssemblyMap:
    """Map of one turn's assembly.

    Attributes:
        piles: objects in the room at the start of the assembly, whether or not it was reached.
        truth: the reference path, in SVG's notation.
        played: the agent's path; empty if it did not move.
        start, target: centres of the cells.
        target_level: level of the target, from 1, the floor.
        placed: centre of the cell in which the agent placed its object; None if it placed nothing.
        placed_level: level of the placed object; 0 if it placed nothing.
        forced: whether a limit forced the placement.
        carried: object that the agent carried; None if it took no step in the assembly.
    """

    piles: tuple[ObjectStack, ...]
    truth: str
    played: str
    start: tuple[float, float]
    target: tuple[float, float]
    target_level: int
    placed: tuple[float, float] | None
    placed_level: int
    forced: bool
    carried: ObjectType | None


class AssemblyReplay:
    """Replays a session, and records the agent's path through the room.

    Args:
        session: a session that has not begun.
    """

    def __init__(self, session: EpisodeSession) -> None:
        self._session = session
        self._paths: tuple[list[RoomCell], list[RoomCell]] = ([], [])
        self._carried: list[ObjectType | None] = [None, None]

    def replay(self, actions: Iterable[int]) -> None:
        """Replay recorded actions."""
        for _ in self._session.replay(actions):
            state = self._session.state
            if state.phase is Phase.ASSEMBLY and not state.finished:
                self._carried[state.turn - 1] = state.carried
                path = self._paths[state.turn - 1]
                if not path or path[-1] != state.square:
                    path.append(state.square)

    def maps(self) -> tuple[AssemblyMap, ...]:
        """Return the maps of both turns, as far as they were played."""
        episode, objects = self._session.episode, self._session.state.room
        before = objects[: len(episode.decoys)], objects[: len(episode.decoys) + 1]  # the placed object comes last
        return tuple(
            _room(before[number], turn, played, self._paths[number], self._carried[number])
            for number, (turn, played) in enumerate(zip(episode.turns, self._session.record().turns, strict=True))
        )


def _room(
    objects: Sequence[PlacedObject],
    turn: Turn,
    played: TurnRecord,
    path: Sequence[RoomCell],
    carried: ObjectType | None,
) -> AssemblyMap:
    placed = played.placed_cell
    cell = turn.target_cell
    return AssemblyMap(
        object_stacks(objects),
        room_polyline(turn.room_path),
        room_polyline(path) if len(path) > 1 else "",
        cell_centre(START),
        cell_centre(RoomCell(cell.column, cell.row)),
        cell.level,
        cell_centre(RoomCell(placed[0], placed[2])) if placed else None,
        placed[1] if placed else 0,
        played.placement_forced,
        carried,
    )


def object_stacks(objects: Sequence[PlacedObject]) -> tuple[ObjectStack, ...]:
    """Return the stacks of the room's objects, by cell."""
    found: dict[RoomCell, list[PlacedObject]] = {}
    for one in objects:
        found.setdefault(RoomCell(one.placement.column, one.placement.row), []).append(one)
    return tuple(
        ObjectStack(*cell_centre(square), tuple(one.type for one in sorted(pile, key=lambda one: one.placement.level)))
        for square, pile in sorted(found.items())
    )


def cell_centre(square: RoomCell) -> tuple[float, float]:
    """Return the centre of a cell; row 0, where the agent starts, is at the bottom."""
    return (square.column + 0.5) * CELL, (ROWS - square.row - 0.5) * CELL


def room_polyline(squares: Sequence[RoomCell]) -> str:
    """Return cells on the map, in SVG's notation."""
    return " ".join(f"{x:g},{y:g}" for x, y in map(cell_centre, squares))

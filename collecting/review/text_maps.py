"""Maps of a text for hosts: the way that it describes, and the ways and cells of its verifiers, for SVG."""

from collections.abc import Sequence
from dataclasses import dataclass

from arramon_collecting.storage.texts.records import Verification
from arramon_server.episodes.episode import Episode
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import PlacedObject
from arramon_server.sim.section import Section
from arramon_server.web.room_map import ObjectStack, cell_centre, object_stacks, room_polyline
from arramon_server.web.section_map import MARGIN, SectionMap, draw_section, place_on_map, polyline

BORDER = 12.0
"""Border of a turn's map around its ways, in units."""


@dataclass(frozen=True, slots=True)
class Way:
    """One verifier's part of a turn.

    Attributes:
        number: number of the verification, from 1.
        points: the way, in SVG's notation; empty if the turn was not begun.
        end: where it ended; None if the turn was not begun.
        placed: centre of the cell in which the object was placed; None if it was not.
    """

    number: int
    points: str
    end: tuple[float, float] | None
    placed: tuple[float, float] | None


@dataclass(frozen=True, slots=True)
class TurnMap:
    """Maps of one turn.

    Attributes:
        view: the part of the section's map that is shown: x, y, width and height.
        truth: the described way.
        start, target: its start, and the position of the target.
        room_truth: the described way in the room.
        room_start, room_target: centres of the cells.
        piles: the objects in the room, before the turn's own is placed.
        ways: the verifiers'.
    """

    view: tuple[float, float, float, float]
    truth: str
    start: tuple[float, float]
    target: tuple[float, float]
    room_truth: str
    room_start: tuple[float, float]
    room_target: tuple[float, float]
    piles: tuple[ObjectStack, ...]
    ways: tuple[Way, ...]


@dataclass(frozen=True, slots=True)
class TextMaps:
    """The section's map, and those of both turns."""

    ground: SectionMap
    turns: tuple[TurnMap, ...]


def text_maps(episode: Episode, section: Section, verifications: Sequence[Verification]) -> TextMaps:
    """Return the maps of a text.

    Args:
        episode: the episode that it describes.
        section: its section.
        verifications: those of the text, in the order of their numbers.
    """
    whole = furnished(section, episode.furniture)
    placed = [PlacedObject(turn.target.type, turn.target_cell) for turn in episode.turns]
    turns = tuple(
        _turn_map(episode, whole, number, (*episode.decoys, *placed[:number]), verifications)
        for number in range(len(episode.turns))
    )
    return TextMaps(draw_section(whole), turns)


def _turn_map(
    episode: Episode,
    section: Section,
    number: int,
    objects: Sequence[PlacedObject],
    verifications: Sequence[Verification],
) -> TurnMap:
    turn = episode.turns[number]
    target = (turn.target.position.x, turn.target.position.z)
    there = [(place, one) for place, one in enumerate(verifications, start=1) if one.has_walk]
    shown = [*turn.path, target, *(point for _, one in there for point in one.path[number])]
    ways = tuple(
        Way(
            place,
            polyline(section, one.path[number]),
            place_on_map(section, one.path[number][-1]) if one.path[number] else None,
            _centre(one.placed_cells[number]),
        )
        for place, one in there
    )
    cell = turn.target_cell
    return TurnMap(
        _view(section, shown),
        polyline(section, turn.path),
        place_on_map(section, turn.path[0]),
        place_on_map(section, target),
        room_polyline(turn.room_path),
        cell_centre(turn.room_path[0]),
        cell_centre(RoomCell(cell.column, cell.row)),
        object_stacks(objects),
        ways,
    )


def _centre(cell: tuple[int, int, int] | None) -> tuple[float, float] | None:
    return None if cell is None else cell_centre(RoomCell(cell[0], cell[2]))


def _view(section: Section, points: Sequence[tuple[float, float]]) -> tuple[float, float, float, float]:
    """Return the part of the map around some places: x, y, width, height; within the map."""
    places = [place_on_map(section, point) for point in points]
    x0, z0, x1, z1 = section.bounds
    width, height = x1 - x0 + 2 * MARGIN, z1 - z0 + 2 * MARGIN
    left = max(min(x for x, _ in places) - BORDER, 0.0)
    top = max(min(y for _, y in places) - BORDER, 0.0)
    right = min(max(x for x, _ in places) + BORDER, width)
    bottom = min(max(y for _, y in places) + BORDER, height)
    return round(left, 1), round(top, 1), round(right - left, 1), round(bottom - top, 1)

"""The maps beside the frame: a turn's street and room with reference, target and objects, for SVG."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from arramon_client.world import STEP
from arramon_server.episodes.episode import Episode
from arramon_server.playback.moments import Moment
from arramon_server.scoring.trajectory import Point2
from arramon_server.sim.geometry import Pose
from arramon_server.sim.room import START, RoomCell
from arramon_server.sim.rules import Phase
from arramon_server.sim.section import Section
from arramon_server.web.map_labels import MapLabel, place_labels
from arramon_server.web.named_things import object_name
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.room_map import ObjectStack, cell_centre, object_stacks, room_polyline
from arramon_server.web.section_map import place_on_map, points_on_map, polyline

PADDING, SMALLEST = 7.0, 30.0
"""Ground shown around the paths, and smallest side of the map, in units."""


@dataclass(frozen=True, slots=True)
class StreetObject:
    """An object in the street on the map.

    Attributes:
        x, y: its place on the map.
        name: its name.
        is_target: whether it is the target.
    """

    x: float
    y: float
    name: str
    is_target: bool


@dataclass(frozen=True, slots=True)
class TurnStage:
    """What the maps of a turn show apart from the agent.

    Attributes:
        number: 1 or 2.
        view: x, y, width and height of the part of the section's map that is shown.
        truth: the reference path, in SVG's notation; empty if it is not shown.
        street: objects in the street; empty if they are not shown.
        piles: objects in the room.
        room_truth: the reference path in the room; empty if it is not shown.
        room_target: centre of the target's cell; None if it is not shown.
        room_level: level of the target's cell, from 1.
        label: the target's name; None if it is not shown, or would cover a path everywhere.
    """

    number: int
    view: tuple[float, float, float, float]
    truth: str
    street: tuple[StreetObject, ...]
    piles: tuple[ObjectStack, ...]
    room_truth: str
    room_target: tuple[float, float] | None
    room_level: int
    label: MapLabel | None

    @property
    def scale(self) -> float:
        """Size of the agent and of names on the street's map, which do not shrink with a wider view."""
        return _scale(self.view)


def turn_stage(
    t: PageTexts, episode: Episode, section: Section, number: int, moments: Sequence[Moment], *, shows_truth: bool
) -> TurnStage:
    """Return the maps of a turn.

    Args:
        t: texts of the page's language.
        episode: the episode.
        section: its section.
        number: 1 or 2.
        moments: the moments of the turn so far; may be empty.
        shows_truth: whether reference, target and other objects in the street are shown.
    """
    turn = episode.turns[number - 1]
    truth = turn.path if shows_truth else ()
    objects = turn.street if shows_truth else ()
    walked = [(moment.state.pose.x, moment.state.pose.z) for moment in moments]
    around = [*truth, *walked] or [(episode.start.x, episode.start.z)]
    around += [(item.position.x, item.position.z) for item in objects[:1]]
    in_room = [moment.state.room for moment in moments if moment.state.phase is Phase.ASSEMBLY]
    before = in_room[0] if in_room else (moments[-1].state.room if moments else episode.decoys)
    cell = turn.target_cell
    view = _view([place_on_map(section, point) for point in around])
    places = [
        (object_name(t, item.type), place_on_map(section, (item.position.x, item.position.z))) for item in objects
    ]
    ways = [points_on_map(section, way) for way in (truth, *_walks(walked))]
    box = view[0], view[1], view[0] + view[2], view[1] + view[3]
    return TurnStage(
        number,
        view,
        polyline(section, truth),
        tuple(StreetObject(*place, name, index == 0) for index, (name, place) in enumerate(places)),
        object_stacks(before),
        room_polyline(turn.room_path) if shows_truth else "",
        cell_centre(RoomCell(cell.column, cell.row)) if shows_truth else None,
        cell.level,
        next(iter(place_labels(box, places[:1], ways, _scale(view))), None),
    )


def _walks(places: Sequence[Point2]) -> list[list[Point2]]:
    """Split the places of one or two runs' moments where the second one begins: no step leads there."""
    walks: list[list[Point2]] = []
    for place in places:
        if walks and math.dist(walks[-1][-1], place) < 2 * STEP:
            walks[-1].append(place)
        else:
            walks.append([place])
    return walks


def room_start() -> tuple[float, float]:
    """Return the centre of the tile on which every assembly begins."""
    return cell_centre(START)


def from_start(start: Pose, place: tuple[float, float]) -> Point2:
    """Return the place (x, z) in the world of one given from a pose as (units to the right, units ahead)."""
    angle = math.radians(start.heading)
    right, ahead, sin, cos = *place, math.sin(angle), math.cos(angle)
    return start.x + right * cos + ahead * sin, start.z - right * sin + ahead * cos


def _scale(view: tuple[float, float, float, float]) -> float:
    return round(view[2] / SMALLEST, 2)


def _view(places: Sequence[tuple[float, float]]) -> tuple[float, float, float, float]:
    """Return a square around some places on the map: x, y, width, height."""
    xs, ys = [x for x, _ in places], [y for _, y in places]
    side = max(max(xs) - min(xs) + 2 * PADDING, max(ys) - min(ys) + 2 * PADDING, SMALLEST)
    x, y = (min(xs) + max(xs) - side) / 2, (min(ys) + max(ys) - side) / 2
    return round(x, 2), round(y, 2), round(side, 2), round(side, 2)

"""The map beside the frame of a film: a turn's street or room from above, drawn with Pillow."""

import math
from collections.abc import Sequence

from PIL import Image, ImageDraw

from arramon_client.world import COLUMNS, ROWS
from arramon_server.web.film.lettering import Colour, fitting, write
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.room_map import CELL, HEIGHT, WIDTH
from arramon_server.web.section_map import SectionMap
from arramon_server.web.watch.stage import TurnStage

STREET, ROOF, EDGE, TEXT = (233, 235, 238), (195, 201, 209), (85, 96, 108), (27, 32, 39)
TRUTH, PLAYED, GOAL, WHITE = (10, 125, 83), (179, 67, 10), (124, 75, 184), (255, 255, 255)
"""Colours, as in `static/style.css`."""

FINE = 2
"""Pixels drawn for each pixel of the film, so that edges are smooth."""

ROOM_MARGIN = 4.0
"""Margin around the room, in the units of its map."""

_ARROW = ((0.0, -1.5), (1.1, 1.2), (0.0, 0.6), (-1.1, 1.2))
"""The agent, facing up, in units."""

Place = tuple[float, float]


class FilmMap:
    """Maps of a turn.

    Args:
        t: texts in the film's language.
        ground: the section's map.
        stage: what the maps show apart from the agent.
        side: side of the square maps, in pixels.
    """

    def __init__(self, t: PageTexts, ground: SectionMap, stage: TurnStage, side: int) -> None:
        self._t = t
        self._stage = stage
        self._side = side
        x, y, width, _ = stage.view
        self._street_view = _View(x, y, side * FINE / width)
        extent = max(WIDTH, HEIGHT) + 2 * ROOM_MARGIN
        self._room_view = _View((WIDTH - extent) / 2, (HEIGHT - extent) / 2, side * FINE / extent)
        self._street, self._room = self._draw_street(ground), self._draw_room()

    def picture(self, *, in_room: bool, trail: Sequence[Place], heading: float, goal: Place | None) -> Image.Image:
        """Return the map at a moment.

        Args:
            in_room: whether the agent is in the room.
            trail: its way in this phase, on the map; the last place is its own.
            heading: its heading, in degrees.
            goal: its waypoint on the map; None if it has none.
        """
        image = (self._room if in_room else self._street).copy()
        view, size = (self._room_view, 1.7) if in_room else (self._street_view, 0.024 * self._stage.view[2])
        draw = ImageDraw.Draw(image)
        if len(trail) > 1:
            draw.line([view.at(place) for place in trail], fill=PLAYED, width=3 * FINE, joint="curve")
        if goal is not None:
            x, y = view.at(goal)
            arm = 1.2 * size * view.scale
            draw.line([(x - arm, y), (x + arm, y)], fill=GOAL, width=2 * FINE)
            draw.line([(x, y - arm), (x, y + arm)], fill=GOAL, width=2 * FINE)
        draw.polygon(view.turned(_ARROW, trail[-1], heading, size), fill=PLAYED, outline=WHITE)
        return image.resize((self._side, self._side), Image.Resampling.LANCZOS)

    def _draw_street(self, ground: SectionMap) -> Image.Image:
        image, view, stage = self._blank(), self._street_view, self._stage
        draw = ImageDraw.Draw(image)
        for roof in ground.roofs:
            draw.polygon([view.at(place) for place in _points(roof)], fill=ROOF, outline=EDGE)
        for x, z in (*ground.props, *((x, z) for x, z, _ in ground.agreed), *ground.from_text):
            _dot(draw, view.at((x, z)), 0.25 * view.scale, EDGE)
        _path(draw, [view.at(place) for place in _points(stage.truth)])
        for item in stage.street:
            radius = (0.028 if item.is_target else 0.014) * self._side * FINE
            _ring(draw, view.at((item.x, item.y)), radius, TRUTH if item.is_target else EDGE)
            if item.is_target:
                x, y = view.at((item.x, item.y))
                _name(draw, (x, y - 1.5 * radius), item.name, 12 * FINE)
        return image

    def _draw_room(self) -> Image.Image:
        image, view, stage, t = self._blank(), self._room_view, self._stage, self._t
        draw = ImageDraw.Draw(image)
        draw.rectangle([view.at((0, 0)), view.at((WIDTH, HEIGHT))], fill=WHITE, outline=EDGE, width=FINE)
        for column in range(1, COLUMNS):
            draw.line([view.at((column * CELL, 0)), view.at((column * CELL, HEIGHT))], fill=ROOF)
        for row in range(1, ROWS):
            draw.line([view.at((0, row * CELL)), view.at((WIDTH, row * CELL))], fill=ROOF)
        size = 9 * FINE
        for pile in stage.piles:
            draw.rectangle([view.at((pile.x - 3, pile.y - 3)), view.at((pile.x + 3, pile.y + 3))], fill=ROOF)
            name = t(f"objects.{pile.types[-1].kind}")
            x, y = view.at((pile.x, pile.y + 4.6))
            write(draw, (x, y), fitting(name, size, round(CELL * view.scale)), size, TEXT, centred=True)
        _path(draw, [view.at(place) for place in _points(stage.room_truth)])
        if stage.room_target is not None:
            _ring(draw, view.at(stage.room_target), 4.2 * view.scale, TRUTH)
        for name, place in (("brick", (WIDTH / 2, -1.2)), ("striped", (WIDTH / 2, HEIGHT + 3.0))):
            write(draw, view.at(place), t(f"objects.wall_{name}"), size, EDGE, centred=True)
        return image

    def _blank(self) -> Image.Image:
        return Image.new("RGB", (self._side * FINE, self._side * FINE), STREET)


class _View:
    """The shown part of a map.

    Args:
        x, y: its upper left corner on the map.
        scale: pixels per unit of the map.
    """

    def __init__(self, x: float, y: float, scale: float) -> None:
        self._x, self._y, self.scale = x, y, scale

    def at(self, place: Place) -> Place:
        """Return the pixel of a place on the map."""
        return (place[0] - self._x) * self.scale, (place[1] - self._y) * self.scale

    def turned(self, shape: Sequence[Place], place: Place, heading: float, size: float) -> list[Place]:
        """Return the pixels of a shape that is turned clockwise, enlarged, and put at a place."""
        angle = math.radians(heading)
        sin, cos = math.sin(angle), math.cos(angle)
        x, y = place
        return [self.at((x + size * (u * cos - v * sin), y + size * (u * sin + v * cos))) for u, v in shape]


def _points(text: str) -> list[Place]:
    """Return the points of an SVG polyline."""
    return [(float(x), float(y)) for x, _, y in (pair.partition(",") for pair in text.split())]


def _path(draw: ImageDraw.ImageDraw, pixels: Sequence[Place]) -> None:
    if len(pixels) > 1:
        draw.line(pixels, fill=WHITE, width=7 * FINE, joint="curve")
        draw.line(pixels, fill=TRUTH, width=4 * FINE, joint="curve")


def _dot(draw: ImageDraw.ImageDraw, pixel: Place, radius: float, colour: Colour) -> None:
    draw.ellipse((pixel[0] - radius, pixel[1] - radius, pixel[0] + radius, pixel[1] + radius), fill=colour)


def _ring(draw: ImageDraw.ImageDraw, pixel: Place, radius: float, colour: Colour) -> None:
    box = (pixel[0] - radius, pixel[1] - radius, pixel[0] + radius, pixel[1] + radius)
    draw.ellipse(box, outline=colour, width=2 * FINE)


def _name(draw: ImageDraw.ImageDraw, pixel: Place, text: str, size: int) -> None:
    """Write a name in the middle above a pixel, on a light ground."""
    for dx, dy in ((-2, 0), (2, 0), (0, -2), (0, 2)):
        write(draw, (pixel[0] + dx, pixel[1] + dy), text, size, WHITE, centred=True)
    write(draw, pixel, text, size, TEXT, centred=True)

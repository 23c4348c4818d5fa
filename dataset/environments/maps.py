"""Top-down maps of the current phase: section or room, the agent, and on open splits the target."""

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt
from PIL import Image

from arramon_client.world import COLUMNS, ROWS
from arramon_dataset.pictures.canvas import BLACK, GREEN, PINK, SWATCHES, WHITE, Canvas
from arramon_dataset.pictures.maps import EDGE, FLOOR, TILE, ground_map
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.sim.room import START
from arramon_server.sim.rules import Phase
from arramon_server.sim.section import Section

SCALE = 8.0
"""Pixels per unit of city maps, before they are scaled to the requested size."""

CACHED_MAPS = 8
"""Maximum number of cached section maps."""


def phase_map(session: EpisodeSession, section: Section, size: int, *, shows_targets: bool) -> npt.NDArray[np.uint8]:
    """Return a top-down map of the current phase.

    Args:
        session: of the episode.
        section: of the episode.
        size: side length of the picture, in pixels.
        shows_targets: whether target and ground truth are drawn.

    Returns:
        (size, size, 3) uint8.
    """
    draw = _room if session.state.phase is Phase.ASSEMBLY else _street
    picture = draw(session, section, shows_targets)
    scale = size / max(picture.size)
    picture = picture.resize((max(1, round(picture.width * scale)), max(1, round(picture.height * scale))))
    square = Image.new("RGB", (size, size), WHITE)
    square.paste(picture, ((size - picture.width) // 2, (size - picture.height) // 2))
    return np.asarray(square)


def _street(session: EpisodeSession, section: Section, shows_targets: bool) -> Image.Image:
    state, canvas = session.state, Canvas(_ground(section).bounds, SCALE, WHITE)
    canvas.image.paste(_ground(section).image)
    turn = session.episode.turns[state.turn - 1]
    if shows_targets:
        canvas.line(turn.path, PINK, 2)
        canvas.dot(turn.target.position.x, turn.target.position.z, 9, None, BLACK, width=3)
        for item in turn.street:
            canvas.dot(item.position.x, item.position.z, 4, SWATCHES[item.type.colour])
    walked = session.record().turns[state.turn - 1].path
    if len(walked) > 1:
        canvas.line(walked, GREEN, 3)
    _agent(canvas, (state.pose.x, state.pose.z), state.pose.heading, 3.0)
    return canvas.image


def _room(session: EpisodeSession, section: Section, shows_targets: bool) -> Image.Image:  # noqa: ARG001 - as in the street
    state, canvas = session.state, Canvas((-0.5, -0.5, COLUMNS - 0.5, ROWS - 0.5), 80.0, FLOOR)
    canvas.rectangle(*START, (0.5, 0.5), 0.0, TILE)
    for column in range(COLUMNS + 1):
        canvas.line([(column - 0.5, -0.5), (column - 0.5, ROWS - 0.5)], EDGE, 1)
    for row in range(ROWS + 1):
        canvas.line([(-0.5, row - 0.5), (COLUMNS - 0.5, row - 0.5)], EDGE, 1)
    for item in state.room:
        column, level, row = item.placement
        canvas.dot(column, row + 0.15 * (level - 1), 16, SWATCHES[item.type.colour])
        canvas.label(column, row - 0.3, item.type.kind, anchor="mm")
    if shows_targets:
        cell = session.episode.turns[state.turn - 1].target_cell
        canvas.dot(cell.column, cell.row, 30, None, PINK, width=4)
    _agent(canvas, (state.square.column, state.square.row), state.room_heading, 0.4)
    return canvas.image


def _agent(canvas: Canvas, place: tuple[float, float], heading: float, length: float) -> None:
    """Draw the agent as a dot, with a line in its viewing direction."""
    angle = math.radians(heading)
    ahead = (place[0] + length * math.sin(angle), place[1] + length * math.cos(angle))
    canvas.line([place, ahead], BLACK, 3)
    canvas.dot(*place, 6, BLACK)


@lru_cache(CACHED_MAPS)
def _ground(section: Section) -> Canvas:
    return ground_map(section, SCALE)

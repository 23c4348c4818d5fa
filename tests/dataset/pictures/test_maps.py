"""Maps of sections and rooms: streets, buildings, furniture, paths and objects."""

from dataclasses import replace

import numpy as np

from arramon_client.world import COLUMNS, ROWS
from arramon_dataset.pictures.canvas import BLACK, GREEN, PINK, SWATCHES, WHITE, Canvas
from arramon_dataset.pictures.maps import (
    AGREED,
    FLOOR,
    OWN,
    PROPS,
    STREET,
    TILE,
    WALKED,
    ground_map,
    recovered_map,
    roof_colour,
    room_map,
    section_map,
)
from arramon_dataset.plans import Plan, Street, build_section
from arramon_server.sim.room import START
from arramon_server.sim.section import Prop
from tests import tiny
from tests.dataset import recovered_split

PLAN = Plan("cross", "Cross", 0.0, (50.0, 20.0), (Street("Main", 6.0, ((0.0, -15.0), (0.0, 15.0))),))


def test_map_shows_a_street_and_buildings_beside_it() -> None:
    section = replace(build_section(PLAN, "test"), props=())
    # Half way up the street's far half: 8 units beyond its middle.
    drawn = np.asarray(ground_map(section, 10.0).image)
    x0, _, _, z1 = section.bounds
    column, row = round((50.0 - x0 + 6) * 10), round((z1 + 6 - 8.0) * 10)
    assert tuple(drawn[row, column]) == STREET
    for house in (column - 55, column + 55):
        column_of_pixels = drawn[row - 20 : row + 20, house]
        roofs = [roof_colour(building.facade) for building in section.buildings]
        assert np.mean([tuple(pixel) in roofs for pixel in column_of_pixels.tolist()]) > 0.4


def test_furniture_is_drawn_at_its_position() -> None:
    section = replace(tiny.SECTION, props=(Prop("phone_booth", -10.0, 5.0, 0.0),))
    canvas = ground_map(section, 10.0)
    assert canvas.image.size == (520, 520)  # the section's 40 units, and six more on every side
    assert canvas.image.getpixel(pixel(canvas, -10.0, 5.0)) == PROPS
    assert canvas.image.getpixel(pixel(canvas, 0.0, 12.0)) == roof_colour("brick")
    assert canvas.image.getpixel(pixel(canvas, 0.0, 5.0)) == STREET


def test_a_zebra_crossing_is_white() -> None:
    section = replace(tiny.SECTION, props=(Prop("zebra_crossing", -10.0, 5.0, 0.0),))
    canvas = ground_map(section, 10.0)
    assert canvas.image.getpixel(pixel(canvas, -11.5, 5.5)) == WHITE


def test_section_map_shows_paths_their_ends_and_objects() -> None:
    episode = tiny.episode("quokka")
    drawn = section_map(tiny.SECTION, episode, 10.0)
    assert drawn.width == 520
    title = drawn.height - 520
    assert 0 < title < 40
    canvas = Canvas((-26.0, -26.0, 26.0, 26.0), 10.0, STREET)

    def at(x: float, z: float) -> object:
        column, row = pixel(canvas, x, z)
        return drawn.getpixel((column, row + title))

    assert at(0.0, 1.0) == PINK  # the way of turn 1
    assert at(1.0, 2.0) == GREEN  # the way of turn 2
    assert at(0.0, 0.0) == BLACK  # where it starts
    assert at(0.0, 2.0) == WHITE  # where turn 2 does
    assert at(0.0, 3.5) == SWATCHES["red"]  # the target of turn 1
    assert at(3.5, 2.0) == SWATCHES["blue"]
    assert at(-6.0, -6.0) == SWATCHES["green"]  # a distracter
    assert at(-0.9, 3.5) == BLACK  # the ring around a target
    assert at(-6.9, -6.0) == STREET  # and none around a distracter


def test_recovered_furniture_is_marked_apart_from_the_episodes_own_and_from_what_was_drawn() -> None:
    canvas = Canvas((-26.0, -26.0, 26.0, 26.0), 16.0, STREET)
    drawn = section_map(recovered_split.SECTION, recovered_split.episode(), 16.0, recovered_split.PROVENANCE)
    title = drawn.height - canvas.image.height

    def at(x: float, z: float) -> object:
        column, row = pixel(canvas, x, z)
        return drawn.getpixel((column, row + title))

    assert at(1.5, 1.0) == AGREED
    assert at(-8.0, 3.0) == AGREED  # where the episode moves it
    assert at(-15.0, -12.0) == STREET  # where the section has it
    assert at(0.0, 5.0) == OWN
    assert at(-9.0, -9.0) == PROPS
    assert at(12.0, -10.0) == PROPS


def test_map_of_a_section_has_paths_and_what_was_recovered_but_nothing_of_single_episodes() -> None:
    canvas = Canvas((-26.0, -26.0, 26.0, 26.0), 16.0, STREET)
    drawn = recovered_map(recovered_split.SECTION, recovered_split.PROVENANCE, [recovered_split.episode()], 16.0)
    title = drawn.height - canvas.image.height

    def at(x: float, z: float) -> object:
        column, row = pixel(canvas, x, z)
        return drawn.getpixel((column, row + title))

    assert at(-15.0, -12.0) == AGREED
    assert at(12.0, -10.0) == PROPS
    assert at(-8.0, 3.0) == STREET
    assert at(0.0, 5.0) == STREET
    assert at(0.0, 1.0) == WALKED
    plain = recovered_map(recovered_split.SECTION, None, [], 16.0)
    column, row = pixel(canvas, -15.0, -12.0)
    assert plain.getpixel((column, row + title)) == PROPS


def test_room_map_shows_start_decoys_and_both_paths() -> None:
    episode = tiny.episode("quokka")
    drawn = room_map(episode, 100.0)
    assert drawn.width == COLUMNS * 100
    title = drawn.height - ROWS * 100
    canvas = Canvas((-0.5, -0.5, COLUMNS - 0.5, ROWS - 0.5), 100.0, FLOOR)

    def at(column: float, row: float) -> object:
        x, y = pixel(canvas, column, row)
        return drawn.getpixel((x, y + title))

    assert at(START[0] + 0.3, START[1] + 0.3) == TILE
    assert at(0.0, 0.0) == SWATCHES["white"]  # the decoy
    assert at(2.0, 0.5) == PINK  # the way of turn 1
    assert at(2.08, 0.5) == GREEN  # that of turn 2, beside it
    assert at(4.0, 4.3) == FLOOR


def pixel(canvas: Canvas, x: float, z: float) -> tuple[int, int]:
    u, v = canvas.at(x, z)
    return round(u), round(v)

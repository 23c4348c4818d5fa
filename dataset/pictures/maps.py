"""Top-down maps of sections and rooms, in the style of the paper's figures."""

from collections.abc import Mapping, Sequence

from PIL import Image

from arramon_client.world import COLUMNS, ROWS
from arramon_dataset.pictures.canvas import BLACK, GREEN, PINK, SWATCHES, WHITE, Canvas, add_title
from arramon_server.episodes.episode import Episode, Turn
from arramon_server.episodes.provenance import AGREEMENT, COLOUR, DRAWN, TEXT, PropOrigin, Provenance
from arramon_server.sim.assets.facades import wall_colour
from arramon_server.sim.assets.roadside import ZEBRA_LENGTH, ZEBRA_WIDTH
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.room import START
from arramon_server.sim.section import Prop, Section

STREET, ROOF, EDGE = (214, 214, 210), (150, 140, 132), (96, 88, 82)
PROPS = (90, 120, 90)
TILE, FLOOR = (245, 215, 90), (238, 234, 226)
AGREED, OWN, WALKED = (190, 70, 10), (30, 80, 200), (190, 190, 205)

_MARKS = {AGREEMENT: (6, AGREED, 12), COLOUR: (6, AGREED, 12), TEXT: (5, OWN, 10), DRAWN: (3, PROPS, 9)}
"""Radius of the dot in pixels, colour, and font size of the label, by a prop's origin."""

LEGEND = (
    "orange: recovered, with the number of votes, or in the colour that the episode's own text says; "
    "blue: put where the episode's own text says; green: drawn"
)


def ground_map(
    section: Section,
    scale: float = 16.0,
    origins: Sequence[PropOrigin] = (),
    facades: Mapping[int, float] | None = None,
    walked: Sequence[Sequence[tuple[float, float]]] = (),
) -> Canvas:
    """Return a map of the section alone: buildings in the colours of their walls, and street furniture.

    Args:
        section: with all furniture to show.
        scale: pixels per unit.
        origins: origin of each of the section's props; empty if all were placed at random.
        facades: votes of the buildings whose facade was recovered, by index.
        walked: paths, each of (x, z), drawn faintly.
    """
    x0, z0, x1, z1 = section.bounds
    canvas = Canvas((x0 - 6, z0 - 6, x1 + 6, z1 + 6), scale, STREET)
    for building in section.buildings:
        half = (building.half_width, building.half_length)
        canvas.rectangle(building.x, building.z, half, building.heading, roof_colour(building.facade), EDGE)
    for path in walked:
        canvas.line(path, WALKED, 1)
    for index, votes in sorted((facades or {}).items()):
        building = section.buildings[index]
        canvas.label(building.x, building.z, f"{building.facade} {votes:.0f}", anchor="mm", colour=AGREED)
    named = list(zip(section.props, origins or [PropOrigin(DRAWN)] * len(section.props), strict=True))
    for prop, origin in sorted(named, key=lambda each: each[1].votes):  # Recovered things are drawn on top.
        _prop(canvas, prop, origin)
    return canvas


def _prop(canvas: Canvas, prop: Prop, origin: PropOrigin) -> None:
    if prop.kind == "zebra_crossing":
        half = (ZEBRA_WIDTH / 2, ZEBRA_LENGTH / 2)
        canvas.rectangle(prop.x, prop.z, half, prop.heading, WHITE)
    radius, colour, size = _MARKS[origin.name]
    canvas.dot(prop.x, prop.z, radius, colour, colour)
    canvas.label(
        prop.x + radius / canvas.scale + 0.1, prop.z, f"{prop_name(prop)}{_votes(origin)}", size=size, colour=colour
    )


def prop_name(prop: Prop) -> str:
    """Return a plain English name of a prop."""
    return " ".join(filter(None, (prop.colour, prop.shape, prop.kind.replace("_", " "))))


def _votes(origin: PropOrigin) -> str:
    return f" {origin.votes:.0f}" if origin.name == AGREEMENT else ""


def roof_colour(facade: str) -> tuple[int, int, int]:
    """Return the colour of a building's roof: a paler tone of its walls."""
    red, green, blue = ((2 * part + ROOF[0]) // 3 for part in wall_colour(facade))
    return red, green, blue


def section_map(
    section: Section, episode: Episode, scale: float = 16.0, provenance: Provenance | None = None
) -> Image.Image:
    """Return a map of the section: the episode's objects, and the ground truth, turn 1 in pink and turn 2 in green.

    Turn 1 goes from the black dot to the white dot, where turn 2 begins. With the section's provenance the map marks
    the things that were recovered, and those placed from the episode's own text.
    """
    origins = () if provenance is None else provenance.origins(section, episode)
    facades = None if provenance is None else provenance.building_votes()
    canvas = ground_map(furnished(section, episode.furniture), scale, origins, facades)
    for turn, colour in zip(episode.turns, (PINK, GREEN), strict=True):
        canvas.line(turn.path, colour)
    for number, turn in enumerate(episode.turns, start=1):
        _street(canvas, turn, number)
    canvas.dot(*episode.turns[0].path[0], 6, BLACK)
    canvas.dot(*episode.turns[1].path[0], 6, WHITE)
    title = f"episode {episode.episode_id}, section {section.id}: turn 1 pink, turn 2 green; targets ringed"
    return add_title(canvas.image, [title] if provenance is None else [title, LEGEND])


def recovered_map(
    section: Section, provenance: Provenance | None, episodes: Sequence[Episode], scale: float = 24.0
) -> Image.Image:
    """Return a map of a section with the paths of its episodes, and with recovered things and their votes."""
    origins = () if provenance is None else provenance.origins(section)
    facades = {} if provenance is None else provenance.building_votes()
    paths = [turn.path for episode in episodes for turn in episode.turns]
    agreed = sum(origin.name == AGREEMENT for origin in origins)
    title = f"section {section.id}: {len(episodes)} episodes, {len(section.props)} pieces of furniture"
    if provenance is not None:
        title += f"; recovered: {agreed} landmarks, {len(facades)} facades, with their votes"
    return add_title(ground_map(section, scale, origins, facades, paths).image, [title])


def _street(canvas: Canvas, turn: Turn, number: int) -> None:
    for item in turn.street:
        canvas.dot(item.position.x, item.position.z, 4, SWATCHES[item.type.colour])
    target = turn.target
    canvas.dot(target.position.x, target.position.z, 10, None, BLACK, width=3)
    canvas.label(target.position.x + 0.8, target.position.z, f"{number}: {target.type}", size=13)


def room_map(episode: Episode, scale: float = 130.0) -> Image.Image:
    """Return a map of the room: decoys, start tile, target cells, and the ground truth of both turns."""
    canvas = Canvas((-0.5, -0.5, COLUMNS - 0.5, ROWS - 0.5), scale, FLOOR)
    canvas.rectangle(*START, (0.5, 0.5), 0.0, TILE)
    for column in range(COLUMNS):
        for row in range(ROWS):
            canvas.line([(column - 0.5, row - 0.5), (column + 0.5, row - 0.5)], EDGE, 1)
            canvas.line([(column - 0.5, row - 0.5), (column - 0.5, row + 0.5)], EDGE, 1)
    for decoy in episode.decoys:
        column, _, row = decoy.placement
        canvas.dot(column, row, 22, SWATCHES[decoy.type.colour])
        canvas.label(column, row + 0.3, f"{decoy.type.pattern} {decoy.type.colour}", anchor="mm")
        canvas.label(column, row - 0.3, decoy.type.kind, anchor="mm")
    for number, (turn, colour) in enumerate(zip(episode.turns, (PINK, GREEN), strict=True), start=1):
        column, level, row = turn.target_cell
        shift = 0.08 * (number - 1)
        canvas.line([(c + shift, r + shift) for c, r in turn.room_path], colour, 4)
        canvas.dot(column + shift, row, 34, None, colour, width=4)
        canvas.label(column, row + 0.12 - 0.16 * (number - 1), f"{number}: {turn.target.type}", anchor="mm")
        canvas.label(column, row - 0.42, f"level {level}" if level > 1 else "", size=10, anchor="mm")
    title = "room: start tile yellow, brick wall above, wood right, spotted left, striped below"
    return add_title(canvas.image, [title])

"""The assembly room as a scene: floor with its grid, the checkered start tile, four walls, a ceiling.

Seen from the start tile, facing row 3: brick ahead, wood on the right, striped behind, spotted on the left. This is
inferred from the release's instructions: objects put against the wooden wall belong in column 4, against the striped
wall in row 0, and "turn to face the dotted wall" is a turn to the left.
"""

from functools import cache

from arramon_client.world import CELL_SIZE, COLUMNS, ROWS
from arramon_server.sim.assets.meshes import Vector, moved, quad
from arramon_server.sim.assets.textures import texture
from arramon_server.sim.labels import SegmentationLabel
from arramon_server.sim.room import START
from arramon_server.sim.scene import Body, BoxCollider, Mesh, Scene

WALL_HEIGHT = 3.0
"""Height of the walls, in units; they are half a cell beyond the outermost cells' centres."""

WALL_TEXTURE_SPAN = 1.5
"""Units that one texture of a wall covers."""

_THICKNESS = 0.2


@cache
def room_scene() -> Scene:
    """Build the room without any objects: cell (column, row) is centred on X = 1.5 column, Y = 1.5 row."""
    west, east = -CELL_SIZE / 2, (COLUMNS - 0.5) * CELL_SIZE
    south, north = -CELL_SIZE / 2, (ROWS - 0.5) * CELL_SIZE
    middle_x, middle_y = (west + east) / 2, (south + north) / 2
    wide, deep = east - west, north - south
    walls = (
        ("brick", (middle_x, north, 0.0), 0.0, wide),
        ("wood", (east, middle_y, 0.0), 90.0, deep),
        ("striped", (middle_x, south, 0.0), 180.0, wide),
        ("spotted", (west, middle_y, 0.0), 270.0, deep),
    )
    bodies = [
        Body(
            f"wall/{look}",
            f"wall/{look}",
            f"wall/{look}",
            position,
            heading,
            collider=BoxCollider(length / 2, _THICKNESS, WALL_HEIGHT),
            label=str(SegmentationLabel("wall", look=look)),
        )
        for look, position, heading, length in walls
    ]
    bodies.append(
        Body(
            "start",
            "tile",
            "start",
            (START.column * CELL_SIZE, START.row * CELL_SIZE, 0.004),
            label=str(SegmentationLabel("start_tile")),
        )
    )
    bodies.append(Body("floor", "floor", "floor", (middle_x, middle_y, 0.0), label="floor"))
    bodies.append(
        Body(
            "ceiling", "ceiling", "ceiling", (middle_x, middle_y, WALL_HEIGHT), label=str(SegmentationLabel("ceiling"))
        )
    )
    meshes = {f"wall/{look}": _wall(length) for look, _, _, length in walls}
    meshes["tile"] = _flat(CELL_SIZE * 0.94, CELL_SIZE * 0.94, 1.0, 1.0)
    meshes["ceiling"] = moved(_flat(wide, deep, COLUMNS, ROWS), pitch=180.0)
    meshes["floor"] = _flat(wide, deep, COLUMNS, ROWS)
    names = {body.texture for body in bodies}
    return Scene("room", tuple(bodies), meshes, {name: texture(name) for name in sorted(names)})


def _wall(length: float) -> Mesh:
    """Build a wall that faces -Y, into the room."""
    x = length / 2
    corners: list[Vector] = [(-x, 0.0, 0.0), (x, 0.0, 0.0), (x, 0.0, WALL_HEIGHT), (-x, 0.0, WALL_HEIGHT)]
    return quad(corners, (0.0, length / WALL_TEXTURE_SPAN), (0.0, WALL_HEIGHT / WALL_TEXTURE_SPAN))


def _flat(width: float, length: float, across: float, along: float) -> Mesh:
    x, y = width / 2, length / 2
    corners: list[Vector] = [(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)]
    return quad(corners, (0.0, across), (0.0, along))

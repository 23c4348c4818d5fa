"""The room's scene: walls, start tile and floor."""

from collections.abc import Iterator

import numpy as np
import pytest

from arramon_client.world import CELL_SIZE, COLUMNS, ROWS, WALLS
from arramon_server.sim.assets.textures import texture
from arramon_server.sim.cameras import Viewpoint
from arramon_server.sim.room import START
from arramon_server.sim.room_scene import WALL_HEIGHT, room_scene
from tests.physics import ReferenceCamera


@pytest.fixture(scope="module")
def world() -> Iterator[ReferenceCamera]:
    with ReferenceCamera(room_scene()) as built:
        yield built


@pytest.mark.parametrize(
    ("heading", "wall", "distance"),
    [
        (0.0, "brick", (ROWS - 0.5) * CELL_SIZE),
        (90.0, "wood", (COLUMNS - 0.5 - START.column) * CELL_SIZE),
        (180.0, "striped", 0.5 * CELL_SIZE),
        (270.0, "spotted", (START.column + 0.5) * CELL_SIZE),
    ],
)
def test_walls_surround_the_start_in_fixed_directions(
    world: ReferenceCamera, heading: float, wall: str, distance: float
) -> None:
    frame = world.render(Viewpoint(START.column * CELL_SIZE, START.row * CELL_SIZE, heading), [], 224)
    assert frame.depth[111, 112] / 1000 == pytest.approx(distance, rel=0.005)
    seen = frame.rgb[100:112, 100:124].reshape(-1, 3).astype(float).mean(axis=0)
    others = {w: texture(f"wall/{w}").reshape(-1, 3).astype(float).mean(axis=0) for w in WALLS}
    assert min(others, key=lambda w: float(np.abs(tint(seen) - tint(others[w])).sum())) == wall


def tint(colour: np.ndarray) -> np.ndarray:
    """The colour without its brightness."""
    share: np.ndarray = colour / colour.sum()
    return share


def test_the_start_tile_is_yellow_and_the_floor_is_not(world: ReferenceCamera) -> None:
    away = world.render(Viewpoint(START.column * CELL_SIZE, 2 * CELL_SIZE, 180.0), [], 224)
    red, green, blue = away.rgb[145, 112].astype(int)
    assert red > green > blue + 60
    ahead = world.render(Viewpoint(START.column * CELL_SIZE, START.row * CELL_SIZE, 0.0), [], 224)
    assert np.ptp(ahead.rgb[200, 112].astype(int)) < 20


def test_the_floor_ends_at_the_walls() -> None:
    scene = room_scene()
    floor = next(body for body in scene.bodies if body.name == "floor")
    corners = scene.meshes["floor"].vertices + np.array(floor.position)
    assert corners.min(axis=0)[:2] == pytest.approx((-0.75, -0.75))
    assert corners.max(axis=0)[:2] == pytest.approx((6.75, 5.25))
    assert {body.collider.height for body in scene.bodies if body.collider} == {WALL_HEIGHT}

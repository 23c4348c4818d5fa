"""The flattened scene: clusters of polygons, bounding spheres, and mipmaps."""

import numpy as np
import pytest

from arramon_server.sim.assets.meshes import box, merge, moved, quad
from arramon_server.sim.raster.scene import CLUSTER, LEVELS, geometry, indices_of, textures

TILES = merge(
    *(quad([(x, y, 0), (x + 9, y, 0), (x + 9, y + 9, 0), (x, y + 9, 0)]) for x in range(0, 99, 9) for y in (0, 9))
)


def test_meshes_are_stored_contiguously() -> None:
    flat = geometry([box(1, 1, 1), TILES, moved(box(1, 2, 3), (5, 0, 0))])
    assert flat.meshes[0].tolist() == [0, 1]
    assert flat.meshes[2].tolist() == [len(flat.clusters) - 1, len(flat.clusters)]
    assert flat.clusters[:, 1].tolist() == [0, *flat.clusters[:-1, 3]]
    assert flat.clusters[:, 0].tolist() == [0, *flat.clusters[:-1, 2]]
    assert flat.clusters[-1, 3] == len(flat.shapes) == len(flat.planes) == 5 + 22 + 5
    assert flat.clusters[-1, 2] == len(flat.points)
    assert flat.shapes[:, 0].tolist() == [0, *np.cumsum(flat.shapes[:-1, 1])]


def test_large_meshes_are_split_into_clusters_within_spheres() -> None:
    wide = merge(*(moved(TILES, (0, 18 * i, 0)) for i in range(4)))
    flat = geometry([wide])
    assert len(flat.clusters) > 3
    for first_point, first_polygon, end_point, end_polygon in flat.clusters:
        assert end_polygon - first_polygon <= CLUSTER
        assert end_point > first_point
    for (first, _, end, _), sphere in zip(flat.clusters, flat.spheres, strict=True):
        assert np.linalg.norm(flat.points[first:end] - sphere[:3], axis=1).max() <= sphere[3]
    assert flat.clusters[-1, 3] == 88


@pytest.mark.parametrize(("height", "width", "levels"), [(4, 4, 3), (256, 192, 9), (88, 72, 8), (1, 1, 1), (5, 3, 4)])
def test_mipmaps_are_stored_below_one_another(height: int, width: int, levels: int) -> None:
    image = np.random.default_rng(3).integers(0, 256, (height, width, 3)).astype(np.uint8)
    packed = textures([np.zeros((2, 2, 3), np.uint8), image])
    first, wide, high, rows, count = packed.places[1].tolist()
    assert (wide, high, count) == (width, height, levels)
    assert count <= LEVELS
    sheet = packed.texels[first:].reshape(rows, width)
    colours = np.stack([sheet & 255, sheet >> 8 & 255, sheet >> 16], axis=-1)
    np.testing.assert_array_equal(colours[:height], image)
    for level in range(1, count):
        top, tall, broad = rows - (rows >> level), -(-height >> level), -(-width >> level)
        assert top + tall <= rows
        assert top >= rows - (rows >> (level - 1)) + -(-height >> (level - 1))  # below the one before
        mean = colours[top : top + tall, :broad].mean()
        assert mean == pytest.approx(image.mean(), abs=25)


def test_mipmap_level_averages_four_texels() -> None:
    image = np.array([[[0, 10, 20], [40, 10, 60]], [[0, 30, 20], [40, 30, 60]]], np.uint8)
    packed = textures([image])
    assert packed.texels[packed.places[0, 3] // 2 * 2] == 20 | 20 << 8 | 40 << 16


def test_indices_follow_the_order_of_names() -> None:
    assert indices_of({"b": 1, "a": 2}) == {"b": 0, "a": 1}
    assert indices_of(("x", "y")) == {"x": 0, "y": 1}

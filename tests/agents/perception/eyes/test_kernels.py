"""Compiled loops give the same results as plain NumPy and SciPy."""

import numpy as np
import pytest
from scipy import ndimage

pytest.importorskip("numba", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.perception.eyes.kernels import label_surfaces, number_parts
from arramon_agents.perception.eyes.pixel_rays import rays


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.6, 0.8, 1.0])
def test_parts_are_numbered_like_scipys(share: float) -> None:
    random = np.random.default_rng(7)
    for _ in range(5):
        marked = random.random((64, 48)) < share
        expected, count = ndimage.label(marked)
        numbers = np.empty(marked.shape, np.int32)
        assert number_parts(marked, numbers) == count
        np.testing.assert_array_equal(numbers, expected)


def test_a_checkerboard_has_as_many_parts_as_fields() -> None:
    marked = np.indices((5, 5)).sum(0) % 2 == 0
    numbers = np.empty(marked.shape, np.int32)
    assert number_parts(marked, numbers) == 13
    assert numbers.max() == 13


def test_surfaces_are_labelled_like_by_numpy() -> None:
    random, size, blocks = np.random.default_rng(8), 112, 28
    crossing, road, eye, lowest, brightness = 3, 1, 1.6, 0.03, 214
    rgb = random.integers(190, 256, (size, size, 3)).astype(np.uint8)
    depth = (random.random((size, size)) * 8.0 * (random.random((size, size)) < 0.9)).astype(np.float32)
    upright, flat = random.integers(5, 9, (blocks, blocks)), random.integers(0, 5, (blocks, blocks))
    height = eye - rays(size)[:, None] * depth
    large = [np.kron(each, np.ones((size // blocks, size // blocks), np.int64)) for each in (upright, flat)]
    expected = np.where((depth > 0.0) & (height > lowest), *large)
    expected[(expected == crossing) & (rgb.min(2) < brightness)] = road
    labels = np.empty((size, size), np.uint16)
    label_surfaces(rgb, depth, upright, flat, rays(size), eye, lowest, crossing, road, brightness, labels)
    np.testing.assert_array_equal(labels, expected)
    assert set(np.unique(labels)) == set(range(9))

"""Cutting things out of synthetic depth images."""

import math

import numpy as np
import pytest

from arramon_agents.perception.eyes.depth_segmentation import CROP_SIZE, FrameThing, crop, find_parts, find_things
from arramon_agents.perception.eyes.reach import FAR, NEAR
from tests.agents.perception.eyes.depth_images import SIZE, image


def test_a_board_is_found_where_it_is() -> None:
    (thing,) = find_things(image((-0.3, 0.1, 3.0, 0.25)))
    assert thing.ahead == pytest.approx(3.0, abs=0.01)
    assert thing.right == pytest.approx(-0.1, abs=0.02)
    assert thing.width == pytest.approx(0.4, abs=0.04)
    assert (thing.low, thing.high) == pytest.approx((0.03, 0.25), abs=0.02)


def test_flat_ground_holds_nothing() -> None:
    assert find_things(image()) == []


def test_a_thing_before_another_is_apart_from_it() -> None:
    things = find_things(image((-0.1, 0.1, 2.0, 0.2), (-0.6, 0.6, 3.0, 0.4)))
    assert [round(thing.ahead) for thing in things] == [2, 3]


def test_walls_and_far_things_are_left_out() -> None:
    assert find_things(image((-2.0, 2.0, 5.0, 0.7))) == []
    for reach in (NEAR, FAR):
        assert find_things(image((-0.5, 0.5, reach.ahead + 1.0, 0.5)), reach) == []
        assert len(find_things(image((-0.5, 0.5, reach.ahead - 1.0, 0.5)), reach)) == 1


def test_small_things_are_left_out() -> None:
    depth = image((-0.2, 0.2, 15.0, 0.25))
    (thing,) = find_things(depth, FAR)
    assert FAR.pixels <= thing.pixels < NEAR.pixels
    assert find_things(depth, NEAR) == []


def test_rims_are_of_the_thing_beside_them_and_small_parts_are_scraps() -> None:
    depth = image((-4.0, 4.0, 14.0, 3.0), (-0.2, 0.2, 3.0, 0.3), (0.9, 1.1, 12.0, 0.2), (-0.2, -0.05, 2.8, 0.25))
    cut = find_parts(depth)
    things, rims = cut.things, cut.rims()
    scraps = cut.is_small[cut.numbers] | cut.is_small[rims]
    assert [round(thing.ahead, 1) for thing in things] == [2.8, 3.0]
    assert scraps[depth == np.float32(12.0)].all()
    behind = depth == np.float32(3.0)
    rim = behind & ~_mask(things[1])
    assert rim.any()
    assert set(rims[rim]) == {cut.parts[1]}
    wall = depth == np.float32(14.0)
    for pixels in (wall, _mask(things[0]), _mask(things[1])):
        assert not scraps[pixels].any()
        assert not rims[pixels].any()


def test_a_crop_holds_the_whole_thing_at_one_scale() -> None:
    for ahead in (1.5, 4.0):
        depth = image((-0.15, 0.15, ahead, 0.3))
        (thing,) = find_things(depth)
        rgb = np.zeros((SIZE, SIZE, 3), np.uint8)
        rgb[thing.rows, thing.columns][thing.mask] = 255
        cut = crop(rgb, depth, thing)
        assert cut.shape == (CROP_SIZE, CROP_SIZE, 6)
        np.testing.assert_array_equal(cut[..., 0] == 1.0, cut[..., 3] == 1.0)
        assert math.isclose(cut[..., 3].mean(), 0.64 * thing.mask.mean() * _squareness(thing.mask.shape), rel_tol=0.15)


def test_a_crop_at_the_edge_is_dark_outside_the_frame() -> None:
    depth = image((0.8, 1.3, 2.0, 0.3))
    (thing,) = find_things(depth)
    cut = crop(np.full((SIZE, SIZE, 3), 255, np.uint8), depth, thing)
    assert thing.columns.stop == SIZE
    assert not cut[:, -1].any()


def _squareness(shape: tuple[int, ...]) -> float:
    return min(shape) / max(shape)


def _mask(thing: FrameThing) -> np.ndarray:
    mask = np.zeros((SIZE, SIZE), np.bool_)
    mask[thing.rows, thing.columns] = thing.mask
    return mask

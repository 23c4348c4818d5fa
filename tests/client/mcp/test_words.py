"""Observations in words and as images."""

import io

import numpy as np
import pytest
from PIL import Image

from arramon_client.agent import Label, Observation
from arramon_client.errors import UsageError
from arramon_client.mcp.pictures import chosen_images, picture
from arramon_client.mcp.words import depth_in_words, things_in_words

LABELS = (
    Label("nothing"),
    Label("road"),
    Label("mug", "red", "dotted"),
    Label("phone_booth"),
    Label("building", look="brick"),
)


def seen(**images: object) -> Observation:
    return Observation("e", 1, "navigation", 0, "go", 0, 9, **images)  # type: ignore[arg-type]


def test_depth_is_described_at_eye_level_from_left_to_right() -> None:
    depth = np.full((20, 20), 1.0, np.float32)  # The ground below, which is not in the way.
    depth[8:11] = 65.535
    depth[9, 0:4], depth[9, 8:12], depth[10, 16:20] = 2.0, (5.0, 4.04, 6.0, 0.0), 0.0
    assert depth_in_words(depth) == "far left: 2.0 m, left: open, ahead: 4.0 m, right: open, far right: open"


def test_things_are_named_with_direction_and_distance_the_nearest_first() -> None:
    segmentation = np.ones((40, 40), np.uint16)
    segmentation[:10], segmentation[10:20, :4], segmentation[10:20, 19:21], segmentation[20:22, 36:] = 0, 4, 2, 3
    depth = np.full((40, 40), 30.0, np.float32)
    depth[20:22, 36:], depth[10:20, :4] = 2.26, 65.535
    assert things_in_words(seen(segmentation=segmentation, depth=depth), LABELS) == [
        "phone booth, 27 degrees right, 2.3 m",
        "dotted red mug, ahead, 30.0 m",
        "brick building, 27 degrees left, far away",
    ]
    assert things_in_words(seen(segmentation=segmentation), LABELS)[0] == "brick building, 27 degrees left"
    assert things_in_words(seen(), LABELS) == []


@pytest.mark.parametrize(("size", "expected"), [(0, (8, 8)), (8, (8, 8)), (20, (20, 20))])
def test_pictures_show_what_was_seen(size: int, expected: tuple[int, int]) -> None:
    rgb = np.zeros((8, 8, 3), np.uint8)
    rgb[:, :4] = (200, 100, 50)
    image = Image.open(io.BytesIO(picture(seen(rgb=rgb), "rgb", "png", size)))
    assert image.size == expected
    assert (image.getpixel((0, 0)), image.getpixel((expected[0] - 1, 0))) == ((200, 100, 50), (0, 0, 0))


def test_near_is_bright_in_pictures_of_depth() -> None:
    depth = np.array([[0.0, 0.1], [10.0, 65.535]], np.float32)
    image = Image.open(io.BytesIO(picture(seen(depth=depth), "depth", "png", 0)))
    assert [*image.tobytes()] == [0, 253, 127, 0]


def test_images_are_those_of_the_sensors() -> None:
    assert [*chosen_images(None, ("rgb", "depth"))] == ["rgb"]
    assert [*chosen_images(None, ("pose",))] == []
    assert [*chosen_images(["depth"], ("rgb", "depth"))] == ["depth"]
    with pytest.raises(UsageError, match="the run has no images of depth; its sensors are rgb"):
        chosen_images(["rgb", "depth"], ("rgb",))

"""Drawing primitives of the pictures: coordinates, text and stacking."""

import numpy as np
import pytest
from PIL import Image

from arramon_dataset.pictures.canvas import BLACK, PINK, WHITE, Canvas, add_title, stack, wrap_text

BOUNDS = (-2.0, 10.0, 6.0, 14.0)
RED, BLUE = (200, 0, 0), (0, 0, 200)


def test_canvas_has_the_size_of_its_bounds_and_one_colour() -> None:
    canvas = Canvas(BOUNDS, 10.0, PINK)
    assert canvas.image.size == (80, 40)
    assert canvas.image.getcolors() == [(80 * 40, PINK)]


@pytest.mark.parametrize(
    ("x", "z", "pixel"), [(-2.0, 14.0, (0, 0)), (6.0, 10.0, (80, 40)), (2.0, 12.0, (40, 20)), (0.0, 13.0, (20, 10))]
)
def test_z_axis_points_up_in_the_picture(x: float, z: float, pixel: tuple[float, float]) -> None:
    assert Canvas(BOUNDS, 10.0, WHITE).at(x, z) == pixel


@pytest.mark.parametrize(
    ("heading", "inside", "outside"),
    [
        (0.0, [(2.0, 13.4), (2.0, 10.6)], [(3.0, 12.0), (1.0, 12.0)]),
        (90.0, [(3.4, 12.0), (0.6, 12.0)], [(2.0, 13.0), (2.0, 11.0)]),
        (45.0, [(2.9, 12.9), (1.1, 11.1)], [(1.1, 12.9), (2.9, 11.1)]),  # clockwise: its length points to +x and +z
    ],
)
def test_rectangle_heading_turns_clockwise(
    heading: float, inside: list[tuple[float, float]], outside: list[tuple[float, float]]
) -> None:
    canvas = Canvas(BOUNDS, 10.0, WHITE)
    canvas.rectangle(2.0, 12.0, (0.25, 1.5), heading, RED)
    for place in inside:
        assert canvas.image.getpixel(round_pixel(canvas.at(*place))) == RED, place
    for place in outside:
        assert canvas.image.getpixel(round_pixel(canvas.at(*place))) == WHITE, place


def round_pixel(place: tuple[float, float]) -> tuple[int, int]:
    return round(place[0]), round(place[1])


def test_lines_and_dots_are_drawn_at_their_positions() -> None:
    canvas = Canvas(BOUNDS, 10.0, WHITE)
    canvas.line([(-1.0, 11.0), (5.0, 11.0)], BLUE, width=3)
    canvas.dot(0.0, 13.0, 4, RED)
    drawn = np.asarray(canvas.image)
    blue = np.argwhere((drawn == BLUE).all(axis=-1))
    assert set(blue[:, 0]) == {29, 30, 31}
    assert (blue[:, 1].min(), blue[:, 1].max()) == (10, 70)
    red = np.argwhere((drawn == RED).all(axis=-1))
    assert red.mean(axis=0) == pytest.approx([10, 20], abs=0.5)  # row and column
    assert np.abs(red - [10, 20]).max() <= 4


def test_ring_does_not_fill_its_inside() -> None:
    canvas = Canvas(BOUNDS, 10.0, WHITE)
    canvas.dot(2.0, 12.0, 8, None, BLACK, width=3)
    assert canvas.image.getpixel((40, 20)) == WHITE
    assert canvas.image.getpixel((47, 20)) == BLACK


def test_label_is_beside_its_position_and_readable_on_black() -> None:
    canvas = Canvas(BOUNDS, 10.0, BLACK)
    canvas.label(0.0, 12.0, "mug")
    seen = np.argwhere((np.asarray(canvas.image) == WHITE).all(axis=-1))
    assert len(seen) > 20
    assert seen[:, 1].min() >= 17  # the column of x = 0, but for the white around the letters
    assert abs(seen[:, 0].mean() - 20) < 5


@pytest.mark.parametrize(
    ("text", "width", "lines"),
    [
        ("", 10, []),
        ("go on to the mug", 10, ["go on to", "the mug"]),
        ("go on to the mug", 100, ["go on to the mug"]),
        ("extraordinarily long", 5, ["extraordinarily", "long"]),  # a word is never cut
        ("to the चाय mug", 20, ["to the mug"]),  # the built-in font has no such letters
        ("café", 20, ["café"]),
    ],
)
def test_lines_are_wrapped_at_words(text: str, width: int, lines: list[str]) -> None:
    assert wrap_text(text, width) == lines


def test_title_is_above_an_unchanged_picture() -> None:
    picture = Image.new("RGB", (120, 30), RED)
    whole = add_title(picture, ["one", "two"], size=14)
    assert whole.size == (120, 30 + 2 * 19 + 10)
    assert whole.crop((0, 48, 120, 78)).getcolors() == [(120 * 30, RED)]
    above = whole.crop((0, 0, 120, 48))
    assert above.getpixel((0, 0)) == WHITE
    assert len(above.getcolors(10_000) or []) > 1


def test_pictures_are_stacked_in_order_with_gaps() -> None:
    whole = stack([Image.new("RGB", (30, 10), RED), Image.new("RGB", (50, 20), BLUE)], gap=4)
    assert whole.size == (50, 10 + 4 + 20 + 4)
    assert [whole.getpixel(at) for at in ((0, 0), (40, 5), (0, 11), (49, 33), (0, 35))] == [
        RED, WHITE, WHITE, BLUE, WHITE,
    ]  # fmt: skip


def test_stacking_no_pictures_is_an_error() -> None:
    with pytest.raises(ValueError, match="empty"):
        stack([])

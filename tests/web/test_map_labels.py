"""Names on maps: where they stand, and what they never cover."""

import pytest

from arramon_server.scoring.trajectory import Point2
from arramon_server.web.map_labels import MapLabel, place_labels

VIEW = (0.0, 0.0, 60.0, 60.0)
DOT = (30.0, 30.0)


@pytest.mark.parametrize(
    ("way", "anchor", "x", "y"),
    [
        ([], "start", 31.2, 30.41),
        ([(32.0, 20.0), (32.0, 40.0)], "end", 28.8, 30.41),  # to the left of a path on the right
        ([(10.0, 30.0), (50.0, 30.0)], "middle", 30.0, 28.2),  # above one that passes from left to right
        ([(10.0, 30.0), (50.0, 30.0), (30.0, 30.0), (30.0, 10.0), (30.0, 50.0)], "start", 32.2, 28.21),  # in a corner
        ([(x / 2, 20.0 + 20.0 * (x % 2)) for x in range(100)], None, 0.0, 0.0),  # nowhere: a path covers all around
    ],
)
def test_a_name_stands_beside_the_path(way: list[Point2], anchor: str | None, x: float, y: float) -> None:
    found = place_labels(VIEW, [("mug", DOT)], [way])
    assert list(found) == ([] if anchor is None else [MapLabel(x, y, anchor, "mug", DOT)])


def test_the_ends_of_paths_and_the_target_stay_in_sight() -> None:
    (mug, bench) = place_labels(VIEW, [("mug", DOT), ("bench", (26.0, 30.0))], [[(34.0, 30.0), (40.0, 30.0)]])
    assert (mug.anchor, bench.anchor) == ("middle", "end")


@pytest.mark.parametrize(("dot", "x"), [((1.0, 30.0), 13.32), ((59.0, 30.0), 46.68)])
def test_a_name_above_its_thing_is_moved_into_the_view(dot: Point2, x: float) -> None:
    ways = [[(dot[0], dot[1]), (30.0, 30.0)]]
    (label,) = place_labels(VIEW, [("a name as long as few others", dot)], ways)
    assert (label.anchor, label.x) == ("middle", x)


def test_names_cover_no_other_name() -> None:
    named = [("a long name of a thing", (x / 3, 30.0)) for x in range(180)]
    found = place_labels(VIEW, named)
    assert 5 < len(found) < len(named)
    width, height = 0.62 * 1.5 * len(named[0][0]), 1.35 * 1.5
    lefts = [(one.x - width * {"start": 0.0, "middle": 0.5, "end": 1.0}[one.anchor], one.y) for one in found]
    for number, (left, baseline) in enumerate(lefts):
        for other, lower in lefts[:number]:
            assert abs(left - other) >= width or abs(baseline - lower) >= height - 0.02


def test_vowel_signs_that_stand_over_letters_take_no_width() -> None:
    edge = (60.0 - 1.2 - 0.6 - 2 * 0.62 * 1.5, 30.0)
    assert place_labels(VIEW, [("चीज़", edge)])[0].anchor == "end"  # three letters: the vowel sign has its width
    assert place_labels(VIEW, [("कुकु", edge)])[0].anchor == "start"  # two letters

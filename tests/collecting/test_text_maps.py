"""Maps of a text with its verifiers, from a literal episode."""

from datetime import UTC, datetime

from arramon_collecting.review.text_maps import text_maps
from arramon_collecting.storage.texts.records import Verification
from tests import tiny

NOON = datetime(2026, 5, 1, 12, tzinfo=UTC)


def walked(task_id: str, *paths: tuple[tuple[float, float], ...], cells: tuple[object, object]) -> Verification:
    return Verification(
        task_id, "people", "t", "1", "bob", "r", (1.0, 1.0), (1.0, 1.0), cells, paths, (), 60.0, True, NOON  # type: ignore[arg-type]
    )  # fmt: skip


def test_ways_and_cells_are_drawn_with_the_described_ones() -> None:
    verifications = [
        walked("v1", ((0.0, 0.0), (0.0, 2.0)), (), cells=((2, 1, 2), None)),
        walked("v2", ((0.0, 0.0),), ((0.0, 2.0), (2.0, 2.0)), cells=((0, 1, 0), (2, 2, 2))),
    ]
    maps = text_maps(tiny.episode("1"), tiny.SECTION, verifications)
    first, second = maps.turns
    assert (first.truth, first.start) == ("26,26 26,25 26,24", (26.0, 26.0))
    assert [(way.number, way.points, way.end, way.placed) for way in first.ways] == [
        (1, "26,26 26,24", (26.0, 24.0), (25.0, 15.0)),
        (2, "26,26", (26.0, 26.0), (5.0, 35.0)),
    ]
    assert [(way.points, way.end, way.placed) for way in second.ways] == [
        ("", None, None), ("26,24 28,24", (28.0, 24.0), (25.0, 15.0)),
    ]  # fmt: skip
    assert first.view == (14.0, 10.5, 24.0, 27.5)
    assert (len(first.piles), len(second.piles)) == (1, 2)  # in turn 2 the first object is in its place


def test_without_verifications_there_is_the_described_way_alone() -> None:
    maps = text_maps(tiny.episode("1"), tiny.SECTION, [])
    assert [turn.ways for turn in maps.turns] == [(), ()]

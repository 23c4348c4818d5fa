"""Cells of the room that spatial relations refer to."""

import math

import pytest

from arramon_client.world import COLUMNS, ROWS
from arramon_lang.cell_grading import START, Room, RoomObject, find_cell, is_all_there, quarter_after, weigh_cells
from arramon_lang.meaning import Assembly, Thing, Where

WALLS = {"brick": 0, "wood": 1, "striped": 2, "spotted": 3}
MUG = RoomObject("mug", "red", "dotted", 1, 2)
TV = RoomObject("tv", "blue", "striped", 3, 2)
BOWL = RoomObject("bowl", "green", "dotted", 3, 2, 2)
BOOK = RoomObject("book", "red", "dotted", 4, 0)
OTHER_MUG = RoomObject("mug", "white", "striped", 4, 3)
ROOM = Room((MUG, TV, BOWL, BOOK, OTHER_MUG), WALLS)

RED_MUG, A_TV, A_BOOK = Thing("mug", "red"), Thing("tv"), Thing("book")
BRICK, WOOD, YOU = Thing("wall", look="brick"), Thing("wall", look="wood"), Thing("you")


def placing(*wheres: Where, turns: tuple[str, ...] = ()) -> Assembly:
    return Assembly(turns, Thing("ball"), wheres)


@pytest.mark.parametrize(
    ("turns", "quarter"),
    [((), 0), (("right",), 1), (("left",), 3), (("around",), 2), (("slightly right",), 0), (("left", "left"), 2),
     (("right", "slightly left"), 1)],
)  # fmt: skip
def test_turns_add_up_to_quarter_headings(turns: tuple[str, ...], quarter: int) -> None:
    assert quarter_after(turns) == quarter


@pytest.mark.parametrize(
    ("relation", "ahead", "right", "left", "around"),
    [
        ("left_of", (0, 2), (1, 3), (1, 1), (2, 2)),
        ("right_of", (2, 2), (1, 1), (1, 3), (0, 2)),
        ("in_front_of", (1, 1), (0, 2), (2, 2), (1, 3)),
        ("behind", (1, 3), (2, 2), (0, 2), (1, 1)),
    ],
)
def test_relations_are_relative_to_the_view_after_the_turns(
    relation: str, ahead: tuple[int, int], right: tuple[int, int], left: tuple[int, int], around: tuple[int, int]
) -> None:
    where = Where(relation, (RED_MUG,))
    for turns, cell in (((), ahead), (("right",), right), (("left",), left), (("around",), around)):
        assert find_cell(placing(where, turns=turns), ROOM)[0] == cell


@pytest.mark.parametrize(
    ("wheres", "cell"),
    [
        ((Where("on_top_of", (A_BOOK,)),), (4, 0)),
        ((Where("on_top_of", (Thing("bowl"),)),), (3, 2)),
        ((Where("between", (RED_MUG, A_TV)),), (2, 2)),
        ((Where("between", (A_TV, WOOD)),), (4, 2)),
        ((Where("between", (BRICK, A_TV)),), (3, 3)),
        ((Where("behind", (RED_MUG,)), Where("left_of", (RED_MUG,))), (0, 3)),
        ((Where("against", (BRICK,)), Where("left_of", (Thing("mug", "white"),))), (3, 3)),
        ((Where("against", (Thing("wall", look="spotted"),)), Where("against", (BRICK,))), (0, 3)),
        ((Where("diagonal_to", (RED_MUG,)), Where("left_of", (A_TV,))), (2, 1)),
        ((Where("in_front_of", (YOU,)),), (2, 1)),
        ((Where("left_of", (YOU,), exactly=True),), (1, 0)),
        ((Where("in_front_of", (YOU,)), Where("against", (BRICK,))), (2, 3)),
        ((Where("near", (A_BOOK,)), Where("against", (WOOD,))), (4, 1)),
        ((Where("in_front_of", (Thing("mug", where=(Where("against", (BRICK,)),)),)),), (4, 2)),
        ((Where("on_top_of", (Thing("mug", which="nearest"),)),), (1, 2)),
        ((Where("on_top_of", (Thing("mug", which="last"),)),), (4, 3)),
        ((Where("left_of", (Thing("mug", "yellow", "dotted"),)),), (0, 2)),
        ((Where("near", (Thing("fountain"),)), Where("on_top_of", (A_BOOK,))), (4, 0)),
    ],
)
def test_best_fitting_cell_is_found(wheres: tuple[Where, ...], cell: tuple[int, int]) -> None:
    assert find_cell(placing(*wheres), ROOM)[0] == cell


def test_objects_ahead_are_preferred_to_objects_aside() -> None:
    room = Room((RoomObject("mug", "red", "dotted", 1, 0), RoomObject("mug", "blue", "striped", 3, 0)), WALLS)
    on_mug = Where("on_top_of", (Thing("mug"),))
    assert find_cell(placing(on_mug, turns=("right",)), room)[0] == (3, 0)
    assert find_cell(placing(on_mug, turns=("left",)), room)[0] == (1, 0)


def test_lead_distinguishes_clear_from_ambiguous_places() -> None:
    clear, unclear = placing(Where("on_top_of", (A_BOOK,))), placing(Where("on_top_of", (Thing("mug"),)))
    assert find_cell(clear, ROOM)[1] > 10
    assert find_cell(unclear, ROOM)[1] == pytest.approx(1.0)


def test_every_cell_but_the_start_has_a_weight() -> None:
    weights = weigh_cells(placing(Where("near", (A_TV,))), ROOM)
    assert len(weights) == COLUMNS * ROWS - 1
    assert START not in weights
    assert all(0.0 < weight <= 1.0 and math.isfinite(weight) for weight in weights.values())
    assert weights[3, 2] < weights[3, 1]  # something stands there


@pytest.mark.parametrize(
    ("thing", "is_there"),
    [
        (RED_MUG, True),
        (Thing("mug", "yellow"), False),
        (WOOD, True),
        (Thing("wall", look="glass"), False),
        (YOU, True),
        (Thing("", "green"), True),
        (Thing("mug", where=(Where("near", (Thing("fountain"),)),)), False),
    ],
)
def test_absent_landmarks_are_detected(thing: Thing, is_there: bool) -> None:
    assert is_all_there(placing(Where("near", (thing,))), ROOM) == is_there

"""The gate rejects false relations and names in a small room."""

import pytest

from arramon_dataset.instructions.gate.assembly import faults_of_assembly
from arramon_lang.cell_grading import Room, RoomObject
from arramon_lang.meaning import Assembly, Thing, Where

ROOM = Room(
    (
        RoomObject("mug", "red", "dotted", 2, 2),
        RoomObject("ball", "blue", "striped", 4, 2),
        RoomObject("book", "blue", "dotted", 0, 3),
    ),
    {"brick": 0, "wood": 1, "spotted": 2, "striped": 3},
)
MUG, BALL = Thing("mug", identity="room/2,1,2"), Thing("ball", "blue", identity="room/4,1,2")
BRICK = Thing("wall", look="brick", identity="wall/brick")


@pytest.mark.parametrize(
    ("relation", "things", "turns", "cell", "fault"),
    [
        ("right_of", (MUG,), (), (3, 2), ""),
        ("left_of", (MUG,), (), (3, 2), "not left_of room/2,1,2"),
        ("in_front_of", (MUG,), (), (2, 1), ""),
        ("behind", (MUG,), (), (2, 1), "not behind"),
        ("behind", (MUG,), ("right",), (3, 2), ""),
        ("between", (MUG, BALL), (), (3, 2), ""),
        ("between", (MUG, BALL), (), (3, 1), "not between"),
        ("on_top_of", (BALL,), (), (4, 2), ""),
        ("on_top_of", (BALL,), (), (4, 3), "not on_top_of"),
        ("near", (MUG,), (), (4, 0), "not near"),
        ("against", (BRICK,), (), (3, 3), "taken for (1, 3), (2, 3), (4, 3)"),
        ("against", (BRICK,), (), (3, 2), "not against wall/brick"),
        ("in_front_of", (Thing("you"),), (), (2, 1), ""),
        ("left_of", (Thing("you"),), (), (3, 1), "not left_of you"),
        ("near", (Thing("", "blue", identity="room/4,1,2"),), (), (3, 2), "may be another"),
        ("near", (Thing("bowl", identity="room/2,1,2"),), (), (3, 2), "is no"),
        ("near", (Thing("mug", identity="room/1,1,1"),), (), (3, 2), "is no"),
    ],
)
def test_what_is_said_of_a_cell(
    relation: str, things: tuple[Thing, ...], turns: tuple[str, ...], cell: tuple[int, int], fault: str
) -> None:
    faults = faults_of_assembly(Assembly(turns, Thing(""), (Where(relation, things),)), cell, ROOM)
    assert faults == () if not fault else any(fault in each for each in faults), faults


def test_one_thing_tells_of_one_place() -> None:
    behind = Thing("ball", "blue", where=(Where("right_of", (MUG,)),), identity="room/4,1,2")
    meaning = Assembly((), Thing(""), (Where("left_of", (behind,)), Where("right_of", (MUG,))))
    assert "room/2,1,2 locates two things at once" in faults_of_assembly(meaning, (3, 2), ROOM)


YOU = Thing("you")
BEYOND_START = Room(
    (RoomObject("mug", "red", "dotted", 1, 1), RoomObject("bowl", "white", "striped", 1, 3)), ROOM.walls
)
ON_THE_RIGHT = "(3, 0), (3, 2), (3, 3), (4, 0), (4, 1), (4, 2), (4, 3)"
OWN_MUG, BOWL = Thing("mug", identity="room/1,1,1"), Thing("bowl", identity="room/1,1,3")


@pytest.mark.parametrize(
    ("wheres", "turns", "cell", "others"),
    [
        ((Where("right_of", (OWN_MUG,)),), (), (2, 1), "(3, 1), (4, 1)"),
        ((Where("right_of", (OWN_MUG,), exactly=True),), (), (2, 1), ""),
        ((Where("right_of", (OWN_MUG,)), Where("right_of", (YOU,))), (), (3, 1), ON_THE_RIGHT),
        ((Where("right_of", (OWN_MUG,)), Where("in_front_of", (YOU,), exactly=True)), (), (2, 1), ""),
        ((Where("right_of", (BOWL,)), Where("against", (BRICK,))), (), (2, 3), "(3, 3), (4, 3)"),
        ((Where("left_of", (OWN_MUG,)),), (), (0, 1), ""),
        ((Where("right_of", (YOU,)),), (), (3, 0), "(3, 1), (3, 2), (3, 3), (4, 0), (4, 1), (4, 2), (4, 3)"),
        ((Where("right_of", (YOU,), exactly=True),), (), (3, 0), ""),
        ((Where("behind", (OWN_MUG,)),), (), (1, 2), ""),
        ((Where("in_front_of", (YOU,)),), (), (2, 1), ""),
        ((Where("in_front_of", (YOU,)),), (), (2, 2), "(2, 1), (2, 3)"),
        ((Where("behind", (OWN_MUG,)), Where("left_of", (OWN_MUG,))), (), (0, 2), "(0, 3)"),
        ((Where("behind", (OWN_MUG,)), Where("left_of", (OWN_MUG,)), Where("against", (BRICK,))), (), (0, 3), ""),
        ((Where("between", (OWN_MUG, BOWL)),), (), (1, 2), ""),
        ((Where("diagonal_to", (BOWL,)),), (), (2, 2), "(0, 2)"),
        ((Where("left_of", (OWN_MUG,)),), ("right",), (1, 2), ""),
        ((Where("near", (OWN_MUG,)),), (), (0, 1), "(1, 0), (1, 2), (2, 1)"),
        ((Where("on_top_of", (OWN_MUG,)),), (), (1, 1), ""),
        ((Where("near", (BOWL,)), Where("left_of", (YOU,))), (), (1, 2), "(0, 2), (0, 3)"),
        ((Where("right_of", (BOWL,), exactly=True), Where("near", (BOWL,))), (), (2, 3), ""),
    ],
)
def test_an_instruction_fits_no_other_free_cell(
    wheres: tuple[Where, ...], turns: tuple[str, ...], cell: tuple[int, int], others: str
) -> None:
    faults = faults_of_assembly(Assembly(turns, Thing(""), wheres), cell, BEYOND_START)
    assert faults == ((f"the cell may be taken for {others}",) if others else ())

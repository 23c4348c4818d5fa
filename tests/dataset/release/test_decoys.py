"""Decoys mentioned by assembly instructions: placed where the instructions are true."""

import pytest

import arramon_lang as lang
from arramon_dataset.release.decoys import identifies_cell
from arramon_dataset.release.missing_objects import DECOYS, arrange_decoys, read_references
from arramon_lang.meaning import Assembly, Thing
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.room import START, RoomCell, RoomPosition
from arramon_server.sim.rules import PlacedObject

FIRST, SECOND = ObjectType("striped", "red", "mug"), ObjectType("dotted", "white", "book")
ELSEWHERE = RoomPosition(4, 1, 0)
ENGLISH = lang.load("en")


def meaning_of(text: str) -> Assembly | None:
    if not text:
        return None
    meaning = ENGLISH.read(text, "assembly")
    assert isinstance(meaning, Assembly)
    return meaning


def room(
    texts: tuple[str, str],
    placements: tuple[RoomPosition, RoomPosition],
    walks: tuple[list[RoomCell], list[RoomCell]] = ([START], [START]),
    episode_id: str = "7",
) -> dict[RoomCell, str]:
    references = (read_references(texts[0], ENGLISH), read_references(texts[1], ENGLISH))
    meanings = (meaning_of(texts[0]), meaning_of(texts[1]))
    found = arrange_decoys(episode_id, (FIRST, SECOND), placements, walks, references, meanings)
    items = [PlacedObject(kind, RoomPosition(cell.column, 1, cell.row)) for kind, cell in found]
    first = PlacedObject(FIRST, placements[0])
    for meaning, placement, placed in zip(meanings, placements, ([], [first]), strict=True):
        assert meaning is None or identifies_cell(meaning, items + placed, placement)
    assert len(found) == len({kind for kind, _ in found}) == DECOYS
    assert START not in {cell for _, cell in found}
    return {cell: str(kind) for kind, cell in found}


@pytest.mark.parametrize(
    ("text", "target", "cell"),
    [
        ("Put it behind the dotted green ball.", (2, 2), (2, 1)),
        ("Turn right and put it behind the dotted green ball.", (3, 1), (2, 1)),
        ("Turn right and put it to the left of the dotted green ball.", (4, 2), (4, 1)),
        ("Turn left and put it in front of the dotted green ball.", (1, 2), (0, 2)),
        ("Turn around and put it to the right of the dotted green ball.", (2, 1), (3, 1)),
        ("Put it between the dotted green ball and the brick wall.", (3, 3), (3, 2)),
    ],
)
def test_landmark_position_is_relative_to_the_view_after_the_turns(
    text: str, target: tuple[int, int], cell: tuple[int, int]
) -> None:
    column, row = target

    assert room((text, ""), (RoomPosition(column, 1, row), ELSEWHERE))[RoomCell(*cell)] == "dotted green ball"


def test_landmark_may_be_on_the_ground_truth_path() -> None:
    walk = [START, RoomCell(2, 1), RoomCell(2, 2)]
    found = room(("Put it behind the dotted green ball.", ""), (RoomPosition(2, 1, 3), ELSEWHERE), (walk, walk))

    assert found[RoomCell(2, 2)] == "dotted green ball"
    assert RoomCell(2, 1) not in found


def test_landmarks_of_between_are_on_opposite_sides() -> None:
    text = "Put it between the dotted green ball and the striped blue book."
    found = room((text, ""), (RoomPosition(3, 1, 2), ELSEWHERE))

    (ball,) = (cell for cell, name in found.items() if name == "dotted green ball")
    (book,) = (cell for cell, name in found.items() if name == "striped blue book")
    assert (ball.column + book.column, ball.row + book.row) == (6, 4)


def test_nested_landmarks_with_incomplete_names_are_placed() -> None:
    text = "Put it to the left of the purple bowl that is in front of the dotted green tv."
    for number in range(10):
        found = room((text, ""), (RoomPosition(2, 1, 1), ELSEWHERE), episode_id=str(number))

        assert found[RoomCell(3, 1)] in ("dotted purple bowl", "striped purple bowl")
        assert found[RoomCell(3, 2)] == "dotted green tv"


def test_first_object_as_a_landmark_needs_no_decoy() -> None:
    text = f"Turn right and put it to the left of the {FIRST}."
    found = room(("", text), (RoomPosition(3, 1, 1), RoomPosition(3, 1, 2)))

    assert str(FIRST) not in found.values()


def test_both_turns_can_mention_one_decoy() -> None:
    texts = ("Put it behind the dotted green ball.", "Put it to the left of the dotted green ball.")
    found = room(texts, (RoomPosition(3, 1, 3), RoomPosition(2, 1, 2)))

    assert found[RoomCell(3, 2)] == "dotted green ball"


def test_decoys_are_determined_by_the_episode_id() -> None:
    texts = ("Put it near the dotted mug.", "Put it diagonally to the purple bowl.")
    places = (RoomPosition(2, 1, 2), RoomPosition(3, 1, 1))

    assert room(texts, places) == room(texts, places)
    assert room(texts, places, episode_id="1") != room(texts, places, episode_id="2")


def test_unsatisfiable_instruction_still_gives_all_decoys() -> None:
    text = "Turn right and put it in front of the dotted green ball."  # which would stand beyond the wall
    places = (RoomPosition(4, 1, 1), RoomPosition(1, 1, 3))
    found = arrange_decoys("1", (FIRST, SECOND), places, ([START], [START]), ((), ()), (meaning_of(text), None))

    assert len(found) == DECOYS
    assert "dotted green ball" in {str(kind) for kind, _ in found}
    assert not {(4, 1), (1, 3), START} & {cell for _, cell in found}


def test_meaning_without_a_place_does_not_change_the_decoys() -> None:
    arguments = "1", (FIRST, SECOND), (RoomPosition(1, 1, 1), ELSEWHERE), ([START], [START]), ((), ())
    nothing = Assembly(("right",), Thing("mug"), ())

    assert arrange_decoys(*arguments, (nothing, None)) == arrange_decoys(*arguments)

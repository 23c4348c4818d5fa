"""Placement network: inputs, and learning of relations from rooms."""

from collections.abc import Sequence
from random import Random

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_agents.reading.reader.slots import rows_of  # noqa: E402
from arramon_agents.simulated.room_examples import WALLS, RoomExample, room_examples_of, with_naming_errors  # noqa: E402
from arramon_agents.vl_map.placement_network import (  # noqa: E402
    CELLS,
    THING,
    WALL,
    YOU,
    CellFinder,
    PlacementNetwork,
    placement_input,
    stack_inputs,
)
from arramon_agents.vl_map.train import train_rooms  # noqa: E402
from arramon_lang.cell_grading import START, Room, RoomObject, find_cell  # noqa: E402
from arramon_lang.meaning import Assembly, Thing, Where  # noqa: E402
from tests import tiny  # noqa: E402

MUG, TV = RoomObject("mug", "red", "dotted", 1, 2), RoomObject("tv", "blue", "striped", 3, 1)
ROOM = Room((MUG, TV), WALLS)


def near(relation: str, *things: Thing, turns: tuple[str, ...] = ()) -> Assembly:
    return Assembly(turns, Thing("ball", "green", "dotted"), (Where(relation, things),))


def test_what_it_is_given() -> None:
    meaning = Assembly(
        ("left",),
        Thing("ball"),
        (Where("behind", (Thing("mug", "red", "striped"),)), Where("near", (Thing("wall", look="wood"),), exactly=True),
         Where("in_front_of", (Thing("you"),))),
    )  # fmt: skip
    given = placement_input(rows_of(meaning), ROOM)
    assert given.turns.tolist() == [1, 0]
    assert [kind for _, _, kind in given.relations.tolist()] == [THING, WALL, YOU, THING]
    assert [exactly for _, exactly, _ in given.relations.tolist()] == [0, 1, 0, 0]
    assert given.marks[:3].tolist() == [[1, 2, 1], [3, 1, 1], [0, 0, 0]]
    assert given.differs[0, 0, :2].tolist() == [[0, 0, 1], [1, 1, 0]]
    assert given.walls[1].tolist() == [1, 0, 1, 1]
    assert given.heights.sum() == 2


def test_the_start_tile_is_never_the_cell() -> None:
    values = PlacementNetwork()(stack_inputs([placement_input(rows_of(near("left_of", Thing("mug"))), ROOM)]))[0]
    assert values.shape == (len(CELLS),)
    assert values.argmin() == CELLS.index(START)


def right_cells(network: PlacementNetwork, tasks: Sequence[RoomExample], reading: int) -> float:
    """Return the share of tasks whose cell is found, given correctly named things."""
    with torch.inference_mode():
        values = network(stack_inputs([placement_input(list(task.readings[reading]), task.room) for task in tasks]))
    found = [CELLS[number] for number in values.argmax(1).tolist()]
    return sum(cell == task.cell for cell, task in zip(found, tasks, strict=True)) / len(tasks)


def test_relations_are_learned() -> None:
    """From rooms with one thing, of which the rules tell the cell: also where it was never seen, and after a turn."""
    torch.set_num_threads(1)
    relations = ("left_of", "right_of", "in_front_of", "behind", "on_top_of")
    cells = [cell for cell in CELLS if cell != START]
    tasks = [
        RoomExample(room, [rows_of(meaning)], find_cell(meaning, room)[0])
        for turns in ((), ("left",))
        for cell in cells
        for relation in relations
        for meaning in [near(relation, Thing("mug"), turns=turns)]
        for room in [Room((RoomObject("mug", "red", "dotted", *cell), RoomObject("tv", "red", "dotted", 0, 3)), WALLS)]
        if find_cell(meaning, room)[1] > 2.0  # It fits better than any other.
    ]
    random = Random(2)
    random.shuffle(tasks)
    held, learned = tasks[:40], tasks[40:]
    network, seconds = train_rooms(learned, seed=1, passes=9600 // len(learned))
    assert right_cells(network, held, 0) > 0.6
    assert seconds > 0.0
    found = CellFinder(network).find(near("left_of", Thing("mug")), ROOM)
    assert found == (0, 2)


def test_rooms_of_episodes() -> None:
    class Reader:
        """Reads as it is written."""

        def read(self, text: str, phase: str) -> Assembly:
            return near("behind", Thing("mug"))

    first, second = room_examples_of([tiny.episode("1")], ("en",), Reader())  # type: ignore[arg-type]
    assert len(first.room.things) == 1
    assert [thing.kind for thing in second.room.things] == ["bowl", "mug"]
    assert second.room.things[1].cell == first.cell == (2, 2)
    assert len(first.readings) == 2


def test_things_are_misnamed_now_and_then() -> None:
    many = Room(tuple(MUG for _ in range(400)), WALLS)
    wrong = sum(thing != MUG for thing in with_naming_errors(many, Random(1)).things)
    assert 20 < wrong < 90

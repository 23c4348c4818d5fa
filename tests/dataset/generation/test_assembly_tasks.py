"""Random assembly tasks and paths in the room."""

from collections import Counter

import pytest

from arramon_dataset.generation.assembly_tasks import TARGET_CELLS, draw_decoys, draw_tasks, walk_to
from arramon_dataset.randomness import seeded
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.room import START, RoomCell

TARGETS = (ObjectType("striped", "red", "mug"), ObjectType("dotted", "white", "book"))


@pytest.mark.parametrize(
    ("target", "blocked", "actions", "cells"),
    [
        ((2, 1), [], "", 1),
        ((2, 3), [], "FF", 3),
        ((3, 0), [], "RRR", 1),
        ((1, 0), [], "LLL", 1),
        ((4, 0), [], "RRRF", 2),
        ((4, 0), [(3, 0)], "FRRRFFRRR", 4),
        ((4, 2), [], "FFRRRF", 4),
        ((2, 2), [(2, 1)], "RRRFLLLFFLLL", 4),
    ],
)
def test_room_path_is_the_shortest(
    target: tuple[int, int], blocked: list[tuple[int, int]], actions: str, cells: int
) -> None:
    path, found = walk_to(RoomCell(*target), {RoomCell(*cell) for cell in blocked})

    assert "".join("FLRP"[action] for action in found) == actions
    assert len(path) == cells


def test_unreachable_cell_is_an_error() -> None:
    with pytest.raises(ValueError, match="no path"):
        walk_to(RoomCell(4, 3), {RoomCell(1, 0), RoomCell(2, 1), RoomCell(3, 0)})


def test_task_frequencies_match_the_original_dataset() -> None:
    tasks = [draw_tasks(seeded("tasks", i)) for i in range(2000)]
    on_first = sum(one.cell.level == 1 and one.cell._replace(level=2) == two.cell for one, two in tasks)
    second = sum(two.cell.level == 2 for _, two in tasks) - on_first
    cells = Counter((task.cell.column, task.cell.row) for pair in tasks for task in pair)

    assert on_first / 2000 == pytest.approx(0.06, abs=0.02)
    assert second / 2000 == pytest.approx(0.29, abs=0.03)
    assert sum(one.cell.level == 2 for one, _ in tasks) / 2000 == pytest.approx(0.29, abs=0.03)
    assert set(cells) == set(TARGET_CELLS)
    assert START not in cells
    assert min(cells.values()) > 200


def test_decoys_leave_both_paths_free() -> None:
    given_up = 0
    for i in range(300):
        tasks = draw_tasks(seeded("decoys", i))
        decoys = draw_decoys(str(i), TARGETS, tasks)
        if decoys is None:
            given_up += 1
            continue
        cells = {RoomCell(decoy.placement.column, decoy.placement.row) for decoy in decoys}
        stands = {RoomCell(task.cell.column, task.cell.row) for task in tasks if task.cell.level == 2}
        assert len({decoy.type for decoy in decoys}) == len(cells) == 8
        assert not cells & {START, *tasks[0].path, *tasks[1].path} - stands
        assert not {decoy.type for decoy in decoys} & set(TARGETS)
        for number, task in enumerate(tasks):
            cell = RoomCell(task.cell.column, task.cell.row)
            is_on_first = number == 1 and cell == RoomCell(tasks[0].cell.column, tasks[0].cell.row)
            assert (cell in cells) == (task.cell.level == 2 and not is_on_first)
    assert given_up < 30

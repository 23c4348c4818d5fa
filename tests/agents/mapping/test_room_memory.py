"""Memory of the room: its walls, as most of their pixels show them."""

import numpy as np
import pytest

from arramon_agents.mapping.room_memory import RoomMemory
from arramon_client.agent import Label
from arramon_client.world import CELL_SIZE, COLUMNS, ROOM_START, ROWS, WALLS

LABELS = (Label("floor"), *(Label("wall", look=look) for look in WALLS), Label("wall", look="plain"))
QUARTERS = dict(zip(WALLS, (1, 0, 3, 2), strict=True))
"""Quarter of each wall, clockwise from the one ahead of the start tile."""

SIZE = 56
COLUMN, ROW = ROOM_START
DEPTHS = [cells * CELL_SIZE for cells in (ROWS - 0.5 - ROW, COLUMNS - 0.5 - COLUMN, ROW + 0.5, COLUMN + 0.5)]
"""Depth of the wall ahead in each quarter, in units."""


def label_of(look: str) -> int:
    return next(number for number, label in enumerate(LABELS) if label.look == look)


def seen(*quarters: int, wrong: dict[int, str] | None = None) -> dict[str, int]:
    """Return the walls remembered of frames of whole walls, in order; of `wrong` ones a tenth shows another look."""
    memory = RoomMemory(LABELS)
    for quarter in quarters:
        look = next(look for look, at in QUARTERS.items() if at == quarter)
        shown = np.full((SIZE, SIZE), label_of(look), np.uint16)
        if wrong and quarter in wrong:
            shown[:, : SIZE // 10] = label_of(wrong[quarter])
        memory.add(np.full((SIZE, SIZE), DEPTHS[quarter], np.float32), shown, ROOM_START, 90 * quarter)
    return dict(memory.room().walls)


def test_walls_are_remembered_as_they_are_seen() -> None:
    assert seen(0, 1, 2, 3) == QUARTERS
    assert seen(2) == {"striped": 2}
    assert seen() == {}


@pytest.mark.parametrize("first", range(4))
@pytest.mark.parametrize("look", [*WALLS, "plain"])
def test_a_few_wrong_pixels_of_the_first_frame_change_no_wall(first: int, look: str) -> None:
    order = [(first + turned) % 4 for turned in range(4)]
    assert seen(*order, wrong={first: look}) == QUARTERS

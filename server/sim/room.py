"""The assembly room: a grid of 5 columns and 4 rows between walls (measured in the release; paper, section 3.1).

In the room's scene, cell (column, row) is centred on X = 1.5 column, Y = 1.5 row.
"""

from typing import NamedTuple

from arramon_client.world import COLUMNS, ROOM_START, ROWS

OBJECT_SCALE = 2.0
"""Scale of collectibles in the room relative to the city, so that they fill a third of a cell."""


class RoomCell(NamedTuple):
    """A cell of the floor."""

    column: int
    row: int

    def is_inside(self) -> bool:
        """Return whether it is one of the room's cells."""
        return 0 <= self.column < COLUMNS and 0 <= self.row < ROWS

    def ahead(self, heading: float) -> "RoomCell":
        """Return the next cell in a heading that is a multiple of 90 degrees (0 towards +row, 90 towards +column)."""
        column, row = ((0, 1), (1, 0), (0, -1), (-1, 0))[round(heading / 90.0) % 4]
        return RoomCell(self.column + column, self.row + row)


START = RoomCell(*ROOM_START)
"""The agent's cell at the start of each assembly, with heading 0: the checkered yellow tile, facing the brick wall."""


class RoomPosition(NamedTuple):
    """Position of an object in the room: the release's `[column, level, row]`."""

    column: int
    level: int
    row: int

"""The assembly room: a grid of 5 columns by 4 rows between four walls (FACTS of the release; paper, section 3.1)."""

from typing import NamedTuple

COLUMNS, ROWS = 5, 4

CELL = 1.5
"""Side of a cell, in units. In the room's scene, cell (column, row) is centred on X = 1.5 column, Y = 1.5 row."""

OBJECT_SCALE = 2.0
"""Collectibles are shown this much larger in the room than in the city, so that they fill a third of a cell."""


class Square(NamedTuple):
    """A cell of the floor."""

    column: int
    row: int

    def is_inside(self) -> bool:
        """Whether it is one of the room's cells."""
        return 0 <= self.column < COLUMNS and 0 <= self.row < ROWS

    def ahead(self, heading: float) -> "Square":
        """The next cell in a heading that is a multiple of 90 degrees (0 towards +row, 90 towards +column)."""
        column, row = ((0, 1), (1, 0), (0, -1), (-1, 0))[round(heading / 90.0) % 4]
        return Square(self.column + column, self.row + row)


START = Square(2, 0)
"""Where the agent starts each assembly phase, heading 0: on the checkered yellow tile, facing the brick wall."""


class Placement(NamedTuple):
    """Where an object stands in the room: the release's `[column, level, row]`."""

    column: int
    level: int
    row: int

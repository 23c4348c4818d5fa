"""Placement network of `vl_map`: predicts the target cell of the assembly room from the parsed instruction.

A log-linear model with learned tables: for each relation, a logit for each offset of the target cell from the reference
object; penalties for mismatched kind, colour and look of a reference object; the agent's heading after its turns.

Shapes in comments: B batch size, R relations, N objects, Q = 4 headings of the agent, C = 20 cells.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn

from arramon_agents.reading.reader.slots import ROTATE, SLOTS, TYPES, WHERE, Row, rows_of
from arramon_client.world import COLUMNS, ROWS
from arramon_lang.cell_grading import START, Cell, Room
from arramon_lang.meaning import TURNS, Assembly

MAX_RELATIONS, MAX_THINGS, MAX_TURNS = 4, 24, 2
"""Maximum numbers of relations, objects and turns in the input."""

MASKED_LOGIT = -30.0
"""Logit of padding."""

CELLS: tuple[Cell, ...] = tuple((column, row) for column in range(COLUMNS) for row in range(ROWS))
ACROSS, MIDDLES = 2 * (COLUMNS - 1) + 1, 4 * (COLUMNS - 1) + 1
"""Number of different offsets along an axis: between two cells, and from a midpoint of two (half cells)."""

THING, WALL, YOU = range(3)
_RELATIONS = len(SLOTS["relation"])
_BETWEEN = SLOTS["relation"].index("between")
_ON_TOP = SLOTS["relation"].index("on_top_of")
_PLACE = {name: number for number, name in enumerate(SLOTS)}
_LOOKS = SLOTS["look1"]

Floats = npt.NDArray[np.float32]
Numbers = npt.NDArray[np.int64]


class PlacementInput(NamedTuple):
    """Input of the network as arrays; a batch has a leading axis.

    Attributes:
        turns: (MAX_TURNS,) ids of the agent's turns, padded with 0.
        relations: (MAX_RELATIONS, 3) relation id, whether it is exact, and the type of reference: THING, WALL or YOU
            (the agent); padded with relation 0.
        differs: (MAX_RELATIONS, 2, MAX_THINGS, 3) whether the named kind, colour and look of the first and second
            reference object differ from those of each object in the room.
        marks: (MAX_THINGS, 3) column and row of each object, and 1, or 0 for padding.
        walls: (MAX_RELATIONS, 4) whether the named wall is not the wall in each direction.
        heights: (C,) number of objects in each cell.
    """

    turns: Numbers
    relations: Numbers
    differs: Floats
    marks: Numbers
    walls: Floats
    heights: Numbers


def placement_input(rows: list[Row], room: Room) -> PlacementInput:
    """Return the network's input for the rows of an instruction and the contents of a room."""
    turns = [TURNS.index(SLOTS["direction"][row[_PLACE["direction"]]]) + 1
             for row in rows if TYPES[row[0]] == ROTATE and row[_PLACE["direction"]]][:MAX_TURNS]  # fmt: skip
    said = [row for row in rows if TYPES[row[0]] == WHERE and row[_PLACE["relation"]]][:MAX_RELATIONS]
    relations = np.zeros((MAX_RELATIONS, 3), np.int64)
    differs = np.zeros((MAX_RELATIONS, 2, MAX_THINGS, 3), np.float32)
    marks = np.zeros((MAX_THINGS, 3), np.int64)
    walls = np.zeros((MAX_RELATIONS, 4), np.float32)
    things = room.things[:MAX_THINGS]
    for number, thing in enumerate(things):
        marks[number] = thing.column, thing.row, 1
    for place, row in enumerate(said):
        names = [[SLOTS[f"{part}{one}"][row[_PLACE[f"{part}{one}"]]] for part in ("kind", "colour", "look")]
                 for one in (1, 2)]  # fmt: skip
        mark = {"wall": WALL, "you": YOU}.get(names[0][0], THING)
        relations[place] = row[_PLACE["relation"]], row[_PLACE["exactly"]], mark
        for number, thing in enumerate(things):
            own = thing.kind, thing.colour, thing.look
            for one in range(2):
                differs[place, one, number] = [
                    bool(word) and word != is_ for word, is_ in zip(names[one], own, strict=True)
                ]
        if mark == WALL:
            quarters = {quarter for look, quarter in room.walls.items() if names[0][2] in ("", look)}
            walls[place] = [float(quarter not in quarters) for quarter in range(4)]
    heights = np.array([room.height(cell) for cell in CELLS], np.int64)
    return PlacementInput(np.array(turns + [0] * (MAX_TURNS - len(turns))), relations, differs, marks, walls, heights)


class PlacementNetwork(nn.Module):
    """Predicts the target cell. Its attribute names are tensor names in the shipped weights."""

    cells: Tensor
    from_walls: Tensor
    is_start: Tensor

    def __init__(self) -> None:
        super().__init__()
        self.against = nn.Parameter(torch.tensor([3.0, 2.0, 1.0]))
        self.facing = nn.Parameter(torch.zeros(MAX_TURNS, len(TURNS) + 1, 4))
        self.wall = nn.Parameter(torch.tensor(3.0))
        self.of_thing = nn.Parameter(torch.zeros(_RELATIONS, 2, ACROSS * ACROSS))
        self.of_you = nn.Parameter(torch.zeros(_RELATIONS, 2, ACROSS * ACROSS))
        self.of_wall = nn.Parameter(torch.zeros(_RELATIONS, 2, COLUMNS))
        self.of_middle = nn.Parameter(torch.zeros(MIDDLES * MIDDLES))
        self.filled = nn.Parameter(torch.zeros(2, 4))
        self.anywhere = nn.Parameter(torch.zeros(ACROSS * ACROSS))
        self.register_buffer("cells", torch.tensor(CELLS), persistent=False)
        self.register_buffer("from_walls", _from_walls(), persistent=False)
        self.register_buffer("is_start", torch.tensor([cell == START for cell in CELLS]), persistent=False)

    def forward(self, given: PlacementInput) -> Tensor:
        """Return the logits of all cells, (B, C)."""
        turns, relations, differs, marks, walls, heights = (torch.as_tensor(part) for part in given)
        facing = torch.stack([self.facing[number, turns[:, number]] for number in range(MAX_TURNS)]).sum(0)  # (B, Q)
        offsets = _rotated_offsets(self.cells - marks[:, :, None, :2])  # (B, Q, N, C, 2)
        own = _rotated_offsets((self.cells - torch.tensor(START))[None])  # (1, Q, C, 2)
        logits = self.anywhere[_offset_index(own)].expand(len(turns), -1, -1)  # (B, Q, C)
        relation, exactly, kind = relations.unbind(2)
        is_on_top = (relation == _ON_TOP).any(1).long()
        logits = logits + self.filled[is_on_top[:, None], heights.clamp(max=3)][:, None]
        padding = torch.where(marks[:, :, 2] > 0, 0.0, MASKED_LOGIT)[:, None, None]
        reference = (-(differs * self.against.abs()).sum(4) + padding).log_softmax(3)  # (B, R, 2, N)
        for number in range(MAX_RELATIONS):
            which = relation[:, number], exactly[:, number]
            by_thing = _gather(self.of_thing[which], _offset_index(offsets))  # (B, Q, N, C)
            of_thing = (by_thing + reference[:, number, 0, None, :, None]).logsumexp(2)
            of_you = _gather(self.of_you[which], _offset_index(own).expand(len(turns), -1, -1))
            by_wall = self.of_wall[which][:, self.from_walls]  # (B, 4, C)
            of_wall = (by_wall + (-self.wall.abs() * walls[:, number]).log_softmax(1)[:, :, None]).logsumexp(1)
            of_middle = self._between(reference[:, number], marks)
            found = torch.where(
                (kind[:, number] == YOU)[:, None, None],
                of_you,
                torch.where((kind[:, number] == WALL)[:, None, None], of_wall[:, None].expand_as(of_you), of_thing),
            )
            found = torch.where((relation[:, number] == _BETWEEN)[:, None, None], of_middle[:, None], found)
            logits = logits + torch.where((relation[:, number] > 0)[:, None, None], found, 0.0)
        marginal: Tensor = (logits + facing.log_softmax(1)[:, :, None]).logsumexp(1)  # over headings
        return marginal.masked_fill(self.is_start, MASKED_LOGIT)

    def _between(self, reference: Tensor, marks: Tensor) -> Tensor:
        """Return the logits of cells by their offset from the midpoint of the two likeliest objects, (B, C)."""
        first = reference[:, 0].argmax(1)
        second = reference[:, 1].scatter(1, first[:, None], MASKED_LOGIT).argmax(1)
        batch = torch.arange(len(marks))
        middle = marks[batch, first, :2] + marks[batch, second, :2]
        off = 2 * self.cells[None] - middle[:, None] + MIDDLES // 2
        found: Tensor = self.of_middle[off[..., 0] * MIDDLES + off[..., 1]]
        return found


class CellFinder:
    """Finds the target cell by a trained network.

    Args:
        network: trained network, in evaluation mode.
    """

    def __init__(self, network: PlacementNetwork) -> None:
        self._network = network

    @torch.inference_mode()
    def find(self, meaning: Assembly, room: Room) -> Cell:
        """Return the cell in which to place the object."""
        logits = self._network(stack_inputs([placement_input(rows_of(meaning), room)]))[0]
        return CELLS[int(logits.argmax())]


def stack_inputs(inputs: list[PlacementInput]) -> PlacementInput:
    """Stack inputs to a batch with a leading axis."""
    return PlacementInput(*(np.stack(part) for part in zip(*inputs, strict=True)))


def _rotated_offsets(offsets: Tensor) -> Tensor:
    """Rotate offsets, (B, ..., 2), to the frame of an agent with each heading, (B, Q, ..., 2): right and ahead."""
    x, y = offsets.unbind(-1)
    return torch.stack([torch.stack(seen, -1) for seen in ((x, y), (-y, x), (-x, -y), (y, -x))], 1)


def _offset_index(offsets: Tensor) -> Tensor:
    """Return the indices of offsets, (..., 2), in a table of offsets."""
    return (offsets[..., 0] + ACROSS // 2) * ACROSS + offsets[..., 1] + ACROSS // 2


def _gather(tables: Tensor, places: Tensor) -> Tensor:
    """Look up indices, (B, ...), in the table of each batch item, (B, values)."""
    return tables.gather(1, places.flatten(1)).view(places.shape)


def _from_walls() -> Tensor:
    """Return the distance of each cell from each wall, in cells, (4, C)."""
    return torch.tensor(
        [[(ROWS - 1 - row, COLUMNS - 1 - column, row, column)[wall] for column, row in CELLS] for wall in range(4)]
    )

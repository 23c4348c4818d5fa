"""The network that finds the cell of the room in which the object is to be placed.

It reads the instruction in a few steps. Each gives a meaning, which scores the things in the room, and the offset of
the target cell: a logit for each difference of columns and rows. Their sums are the logits of the cells.

In the comments B is the batch, T words, H = 192 numbers of a word, N = 20 cells.
"""

import torch
from torch import Tensor, nn

from arramon_agents.vl_grounded.attributes import Attributes
from arramon_agents.vl_grounded.instruction_encoder import DROPOUT, HIDDEN, Attention, InstructionEncoder, match
from arramon_client.world import COLUMNS, ROWS

CELLS, LEVELS, STEPS, STATE = COLUMNS * ROWS, 2, 5, 128
"""N; levels of stacked things in a cell; steps in which an instruction is read; size of the state."""

OFFSETS = (2 * COLUMNS - 1) * (2 * ROWS - 1)
"""Differences of columns and rows."""


class RoomNetwork(nn.Module):
    """Finds the target cell."""

    def __init__(self) -> None:
        super().__init__()
        self.attention = Attention(STATE, 2)
        self.memory = nn.LSTMCell(2 * HIDDEN + 2 * LEVELS + 2, STATE)
        self.offsets = nn.Linear(STATE + HIDDEN, OFFSETS * LEVELS)
        self.anywhere = nn.Linear(STATE, CELLS)
        self.filled = nn.Linear(STATE, LEVELS)
        self.dropout = nn.Dropout(DROPOUT)
        self.register_buffer("between", _differences(), persistent=False)

    def forward(self, reading: InstructionEncoder, words: Tensor, tokens: Tensor, there: Attributes) -> Tensor:
        """Return the logits of all cells, (B, N), row by row.

        Args:
            reading: the text encoder.
            words: in context, (B, T, H).
            tokens: (B, T).
            there: things by cell and level, (B, N LEVELS, ...); 0 where nothing is.
        """
        count = len(tokens)
        hidden = cell = words.new_zeros(count, STATE)
        looks = self.attention.first(tokens)
        is_filled = there.kinds.amax(-1).view(count, CELLS, LEVELS)
        values = words.new_zeros(count, CELLS)
        for _ in range(STEPS):
            read, looks = self.attention(hidden, words, tokens == 0, looks)  # (B, 2, H): a thing, and a relation
            fits = match(reading.meant(read[:, :1]), there)[:, 0].view(count, CELLS, LEVELS)
            known = torch.cat([read.flatten(1), fits.sum(1), fits.amax(1), is_filled.sum(1) / 10], 1)
            hidden, cell = self.memory(self.dropout(known), (hidden, cell))
            offsets = self.offsets(self.dropout(torch.cat([hidden, read[:, 1]], 1))).view(count, LEVELS, OFFSETS)
            by_thing = offsets[:, :, self.between]  # (B, LEVELS, N of the cell, N of the thing)
            values = values + torch.einsum("blnm,bml->bn", by_thing, fits)
        values = values + self.anywhere(self.dropout(hidden))
        found: Tensor = values + (is_filled * self.filled(hidden)[:, None]).sum(2)
        return found


def _differences() -> Tensor:
    """Return the index in OFFSETS from each cell to each other, (N, N)."""
    column, row = torch.arange(CELLS) % COLUMNS, torch.arange(CELLS) // COLUMNS
    columns = column[:, None] - column + COLUMNS - 1
    rows = row[:, None] - row + ROWS - 1
    return rows * (2 * COLUMNS - 1) + columns

"""Placement network of `vl_grounded`: predicts the target cell of the assembly room.

An LSTM attends to the instruction in STEPS steps. Each step matches the objects in the room with words that name one,
and predicts the offset of the target cell from it: a logit for each difference of columns and rows. Summed over steps,
they are the logits of the cells.

Shapes in comments: B batch size, T tokens, H hidden size of a word (192), N = 20 cells.
"""

import torch
from torch import Tensor, nn

from arramon_agents.vl_grounded.attributes import Attributes
from arramon_agents.vl_grounded.instruction_encoder import DROPOUT, HIDDEN, Attention, InstructionEncoder, match
from arramon_client.world import COLUMNS, ROWS

CELLS, LEVELS, STEPS, STATE = COLUMNS * ROWS, 2, 5, 128
"""N; levels of stacked objects in a cell; decoding steps per instruction; hidden size of the LSTM."""

OFFSETS = (2 * COLUMNS - 1) * (2 * ROWS - 1)
"""Number of differences of columns and rows between two cells."""


class GroundedPlacementNetwork(nn.Module):
    """Predicts the target cell. Its attribute names are tensor names in the shipped weights."""

    def __init__(self) -> None:
        super().__init__()
        self.attention = Attention(STATE, 2)
        self.memory = nn.LSTMCell(2 * HIDDEN + 2 * LEVELS + 2, STATE)
        self.offsets = nn.Linear(STATE + HIDDEN, OFFSETS * LEVELS)
        self.anywhere = nn.Linear(STATE, CELLS)
        self.filled = nn.Linear(STATE, LEVELS)
        self.dropout = nn.Dropout(DROPOUT)
        self.register_buffer("between", _offset_indices(), persistent=False)

    def forward(self, encoder: InstructionEncoder, words: Tensor, tokens: Tensor, seen: Attributes) -> Tensor:
        """Return the logits of all cells, (B, N), row by row.

        Args:
            encoder: the text encoder.
            words: encoded words, (B, T, H).
            tokens: token ids, (B, T).
            seen: attributes of the objects by cell and level, (B, N LEVELS, ...); 0 where there is none.
        """
        count = len(tokens)
        hidden = cell = words.new_zeros(count, STATE)
        attention = self.attention.initial(tokens)
        is_filled = seen.kinds.amax(-1).view(count, CELLS, LEVELS)
        logits = words.new_zeros(count, CELLS)
        for _ in range(STEPS):
            # Two heads, (B, 2, H): words that name an object, words that name a relation.
            context, attention = self.attention(hidden, words, tokens == 0, attention)
            matches = match(encoder.probabilities(context[:, :1]), seen)[:, 0].view(count, CELLS, LEVELS)
            features = torch.cat([context.flatten(1), matches.sum(1), matches.amax(1), is_filled.sum(1) / 10], 1)
            hidden, cell = self.memory(self.dropout(features), (hidden, cell))
            offsets = self.offsets(self.dropout(torch.cat([hidden, context[:, 1]], 1))).view(count, LEVELS, OFFSETS)
            by_object = offsets[:, :, self.between]  # (B, LEVELS, N of the target cell, N of the object)
            logits = logits + torch.einsum("blnm,bml->bn", by_object, matches)
        logits = logits + self.anywhere(self.dropout(hidden))
        total: Tensor = logits + (is_filled * self.filled(hidden)[:, None]).sum(2)
        return total


def _offset_indices() -> Tensor:
    """Return the index in OFFSETS of the difference between each pair of cells, (N, N)."""
    column, row = torch.arange(CELLS) % COLUMNS, torch.arange(CELLS) // COLUMNS
    columns = column[:, None] - column + COLUMNS - 1
    rows = row[:, None] - row + ROWS - 1
    return rows * (2 * COLUMNS - 1) + columns

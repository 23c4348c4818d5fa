"""The walking network: it reads along as it walks, matches what it sees with what it reads, and chooses an action.

In the comments B is the batch, S steps, T words, H = 192 numbers of a word, N = 49 cells, R = 3 reads.
"""

from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor, nn

from arramon_agents.perception.encoder import GRID
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES
from arramon_agents.vl.model import ACTIONS
from arramon_agents.vl_grounded.attributes import Attributes, attributes_of
from arramon_agents.vl_grounded.instruction_encoder import DROPOUT, HIDDEN, Attention, InstructionEncoder, match
from arramon_agents.vl_grounded.odometry import NUMBERS

CELLS, CELL, BRIEF, SCENE, ACT, STATE, READS = GRID * GRID, 64, 8, 96, 16, 192, 3
"""N; sizes of a cell, of a cell within the scene, of the scene, of an action, of the state; R."""


class StepInput(NamedTuple):
    """Input of a step besides the words.

    Attributes:
        cells: (B, N, CELL).
        scene: summary of all cells, (B, SCENE).
        there: the names in each cell, (B, N, ...).
        target: how well each cell matches the object to pick up, (B, N).
        walked: the last action and the odometry, (B, ...).
    """

    cells: Tensor
    scene: Tensor
    there: Attributes
    target: Tensor
    walked: Tensor


class RecurrentState(NamedTuple):
    """Recurrent state: the LSTM's two states, (B, STATE) each, and the attention, (B, 2 R, T)."""

    hidden: Tensor
    cell: Tensor
    looks: Tensor


class StreetNetwork(nn.Module):
    """Chooses an action at each step of a navigation phase."""

    def __init__(self) -> None:
        super().__init__()
        self.of_target = Attention(1, 1)
        self.cell = nn.Sequential(nn.Linear(len(CHANNEL_NAMES) + 2 * GRID, CELL), nn.ReLU(), nn.Linear(CELL, CELL))
        self.brief = nn.Linear(CELL, BRIEF)
        self.scene = nn.Sequential(nn.ReLU(), nn.Linear(CELLS * BRIEF, SCENE), nn.ReLU())
        self.act = nn.Embedding(ACTIONS + 1, ACT)
        self.attention = Attention(STATE, READS)
        self.seek = nn.Linear(HIDDEN, CELL)
        self.mix = nn.Linear(READS * (HIDDEN // 2 + CELLS + CELL) + CELLS + SCENE + ACT + NUMBERS, STATE)
        self.shorten = nn.Linear(HIDDEN, HIDDEN // 2)
        self.memory = nn.LSTMCell(STATE, STATE)
        self.output = nn.Sequential(nn.Linear(2 * STATE, STATE // 2), nn.ReLU(), nn.Linear(STATE // 2, ACTIONS))
        self.dropout = nn.Dropout(DROPOUT)

    def read_target(self, words: Tensor, tokens: Tensor) -> Tensor:
        """Return the read of the object to pick up, (B, H)."""
        ask = words.new_ones(len(words), 1)
        read: Tensor = self.of_target(ask, words, tokens == 0, self.of_target.first(tokens))[0]
        return read[:, 0]

    def see(
        self, reading: InstructionEncoder, target: Tensor, cells: Tensor, before: Tensor, odometry: Tensor
    ) -> list[StepInput]:
        """Return the inputs of S consecutive steps.

        Args:
            reading: the text encoder.
            target: of `read_target`.
            cells: features of the images, (B, S, 7, 7, channels).
            before: the action before each step, (B, S); START at the first.
            odometry: (B, S, NUMBERS).
        """
        cells = cells.flatten(2, 3)  # (B, S, N, channels)
        there = attributes_of(cells)
        place = torch.eye(GRID, device=cells.device)
        places = torch.cat([place.repeat_interleave(GRID, 0), place.repeat(GRID, 1)], 1)  # (N, 14)
        seen = self.cell(torch.cat([cells, places.expand(*cells.shape[:2], -1, -1)], -1))  # (B, S, N, CELL)
        scene = self.scene(self.brief(seen).flatten(2))
        flat = Attributes(*(part.flatten(1, 2) for part in there))  # (B, S N, ...)
        is_target = match(reading.meant(target[:, None]), flat)[:, 0].view(seen.shape[:3])
        walked = torch.cat([self.act(before), odometry], -1)
        steps = [part.unbind(1) for part in (seen, scene, *there, is_target, walked)]
        return [
            StepInput(cells, scene, Attributes(*there), target, walked)
            for cells, scene, *there, target, walked in zip(*steps, strict=True)
        ]

    def first(self, tokens: Tensor) -> RecurrentState:
        """Return the recurrent state before the first step."""
        zero = torch.zeros(len(tokens), STATE, device=tokens.device)
        return RecurrentState(zero, zero, self.attention.first(tokens))

    def step(
        self, reading: InstructionEncoder, words: Tensor, tokens: Tensor, seen: StepInput, mind: RecurrentState
    ) -> tuple[Tensor, RecurrentState]:
        """Return the features from which a step's action is chosen, (B, 2 STATE), and the next recurrent state."""
        read, looks = self.attention(mind.hidden, words, tokens == 0, mind.looks)  # (B, R, H)
        maps = match(reading.meant(read), seen.there)  # (B, R, N)
        scores = (self.seek(read) @ seen.cells.transpose(1, 2)) / CELL**0.5
        found = scores.softmax(2) @ seen.cells  # (B, R, CELL)
        of_words = torch.cat([self.shorten(read), maps, found], 2).flatten(1)
        mixed = nn.functional.relu(self.mix(torch.cat([of_words, seen.target, seen.scene, seen.walked], 1)))
        hidden, cell = self.memory(self.dropout(mixed), (mind.hidden, mind.cell))
        return torch.cat([hidden, mixed], 1), RecurrentState(hidden, cell, looks)

    def forward(self, reading: InstructionEncoder, words: Tensor, tokens: Tensor, seen: Sequence[StepInput]) -> Tensor:
        """Return the logits of all actions at all steps, (B, S, ACTIONS)."""
        mind, found = self.first(tokens), []
        for each in seen:
            mixed, mind = self.step(reading, words, tokens, each, mind)
            found.append(mixed)
        values: Tensor = self.output(self.dropout(torch.stack(found, 1)))
        return values

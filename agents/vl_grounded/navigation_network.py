"""Navigation network of `vl_grounded`: attends to words at each step, matches them to image cells, chooses an action.

Shapes in comments: B batch size, S steps, T tokens, H hidden size of a word (192), N = 49 image cells, R = 3 heads.
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
from arramon_agents.vl_grounded.odometry import ODOMETRY_SIZE

CELLS, CELL, BRIEF, SCENE, ACT, STATE, HEADS = GRID * GRID, 64, 8, 96, 16, 192, 3
"""N; sizes of cell embedding, of a cell in the scene summary, of the summary, action embedding, recurrent state; R."""


class StepInput(NamedTuple):
    """Input of one step, besides the words.

    Attributes:
        cells: cell embeddings, (B, N, CELL).
        scene: summary of all cells, (B, SCENE).
        attributes: attributes seen in each cell, (B, N, ...).
        target_match: match of each cell with the target object, (B, N).
        motion: embedding of the previous action, and odometry, (B, ...).
    """

    cells: Tensor
    scene: Tensor
    attributes: Attributes
    target_match: Tensor
    motion: Tensor


class RecurrentState(NamedTuple):
    """Hidden and cell state of the LSTM, (B, STATE) each, and the attention over the words, (B, 2 R, T)."""

    hidden: Tensor
    cell: Tensor
    attention: Tensor


class GroundedNavigationNetwork(nn.Module):
    """Recurrent policy of a navigation phase. Its attribute names are tensor names in the shipped weights."""

    def __init__(self) -> None:
        super().__init__()
        self.of_target = Attention(1, 1)
        self.cell = nn.Sequential(nn.Linear(len(CHANNEL_NAMES) + 2 * GRID, CELL), nn.ReLU(), nn.Linear(CELL, CELL))
        self.brief = nn.Linear(CELL, BRIEF)
        self.scene = nn.Sequential(nn.ReLU(), nn.Linear(CELLS * BRIEF, SCENE), nn.ReLU())
        self.act = nn.Embedding(ACTIONS + 1, ACT)
        self.attention = Attention(STATE, HEADS)
        self.seek = nn.Linear(HIDDEN, CELL)
        self.mix = nn.Linear(HEADS * (HIDDEN // 2 + CELLS + CELL) + CELLS + SCENE + ACT + ODOMETRY_SIZE, STATE)
        self.shorten = nn.Linear(HIDDEN, HIDDEN // 2)
        self.memory = nn.LSTMCell(STATE, STATE)
        self.output = nn.Sequential(nn.Linear(2 * STATE, STATE // 2), nn.ReLU(), nn.Linear(STATE // 2, ACTIONS))
        self.dropout = nn.Dropout(DROPOUT)

    def read_target(self, words: Tensor, tokens: Tensor) -> Tensor:
        """Return the context vector of the words that name the target object, (B, H)."""
        query = words.new_ones(len(words), 1)
        context: Tensor = self.of_target(query, words, tokens == 0, self.of_target.initial(tokens))[0]
        return context[:, 0]

    def step_inputs(
        self, encoder: InstructionEncoder, target: Tensor, cells: Tensor, previous_actions: Tensor, odometry: Tensor
    ) -> list[StepInput]:
        """Return the inputs of S consecutive steps.

        Args:
            encoder: the text encoder.
            target: context vector of the target object, from `read_target`.
            cells: image features, (B, S, 7, 7, channels).
            previous_actions: the action before each step, (B, S); START_ACTION before the first.
            odometry: (B, S, ODOMETRY_SIZE).
        """
        cells = cells.flatten(2, 3)  # (B, S, N, channels)
        attributes = attributes_of(cells)
        one_hot = torch.eye(GRID, device=cells.device)
        positions = torch.cat([one_hot.repeat_interleave(GRID, 0), one_hot.repeat(GRID, 1)], 1)  # (N, 14)
        embedded = self.cell(torch.cat([cells, positions.expand(*cells.shape[:2], -1, -1)], -1))  # (B, S, N, CELL)
        scene = self.scene(self.brief(embedded).flatten(2))
        flat = Attributes(*(part.flatten(1, 2) for part in attributes))  # (B, S N, ...)
        target_match = match(encoder.probabilities(target[:, None]), flat)[:, 0].view(embedded.shape[:3])
        motion = torch.cat([self.act(previous_actions), odometry], -1)
        steps = [part.unbind(1) for part in (embedded, scene, *attributes, target_match, motion)]
        return [
            StepInput(cells, scene, Attributes(*attributes), target, motion)
            for cells, scene, *attributes, target, motion in zip(*steps, strict=True)
        ]

    def initial_state(self, tokens: Tensor) -> RecurrentState:
        """Return the recurrent state before the first step."""
        zero = torch.zeros(len(tokens), STATE, device=tokens.device)
        return RecurrentState(zero, zero, self.attention.initial(tokens))

    def step(
        self, encoder: InstructionEncoder, words: Tensor, tokens: Tensor, inputs: StepInput, state: RecurrentState
    ) -> tuple[Tensor, RecurrentState]:
        """Return the features that predict a step's action, (B, 2 STATE), and the next recurrent state."""
        context, attention = self.attention(state.hidden, words, tokens == 0, state.attention)  # (B, R, H)
        matches = match(encoder.probabilities(context), inputs.attributes)  # (B, R, N)
        scores = (self.seek(context) @ inputs.cells.transpose(1, 2)) / CELL**0.5
        attended = scores.softmax(2) @ inputs.cells  # (B, R, CELL)
        by_head = torch.cat([self.shorten(context), matches, attended], 2).flatten(1)
        features = torch.cat([by_head, inputs.target_match, inputs.scene, inputs.motion], 1)
        mixed = nn.functional.relu(self.mix(features))
        hidden, cell = self.memory(self.dropout(mixed), (state.hidden, state.cell))
        return torch.cat([hidden, mixed], 1), RecurrentState(hidden, cell, attention)

    def forward(self, encoder: InstructionEncoder, words: Tensor, tokens: Tensor, steps: Sequence[StepInput]) -> Tensor:
        """Return the action logits at all steps, (B, S, ACTIONS)."""
        state, outputs = self.initial_state(tokens), []
        for inputs in steps:
            output, state = self.step(encoder, words, tokens, inputs, state)
            outputs.append(output)
        logits: Tensor = self.output(self.dropout(torch.stack(outputs, 1)))
        return logits

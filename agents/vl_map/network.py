"""Policy network of `vl_map`: a transformer over tokens of instruction rows, landmarks, past positions and directions.

Its outputs are logits of the options (waypoints, landmarks to pick up) and of the row that is being carried out.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from arramon_agents.reading.reader.slots import SLOTS
from arramon_agents.vl_map.features import (
    DIRECTIONS,
    GROUND_CHANNELS,
    RADII,
    ROWS,
    STATE_VALUES,
    THING_VALUES,
    THINGS,
    TRACE,
    PolicyInput,
)
from arramon_agents.vl_map.options import DISTANCES

NEARNESS = (0.0, 1.0, 2.0, 3.2, 5.0, 7.5, 11.0, 16.0, 24.0)
"""Centres of the soft bins of distances, in units."""

AGES = (0.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
"""Centres of the soft bins of ages, in moves."""

WHERE = SLOTS["type"].index("where")

MASKED_LOGIT = -30.0
"""Logit of padding."""


@dataclass(frozen=True, slots=True)
class PolicySizes:
    """Sizes of the network. Field names are keys in files of weights.

    Attributes:
        width: embedding size of a token.
        heads: number of attention heads.
        layers: number of transformer layers.
        inner: hidden size of the feed-forward layers.
        dropout: dropout probability.
    """

    width: int = 64
    heads: int = 4
    layers: int = 3
    inner: int = 128
    dropout: float = 0.0


HEAD = 16
"""Size of an attention head, for `sizes_of`."""


def sizes_of(width: int, layers: int) -> PolicySizes:
    """Return the sizes of a network by its width and depth.

    Raises:
        ValueError: if the width is no positive multiple of HEAD, or there are fewer than two layers.
    """
    if width < HEAD or width % HEAD:
        raise ValueError(f"a width of {width}, expected a positive multiple of {HEAD}")
    if layers < 2:
        raise ValueError(f"{layers} layers, expected at least 2")
    return PolicySizes(width, heads=width // HEAD, layers=layers, inner=2 * width)


class PolicyBatch(NamedTuple):
    """The arrays of `features.PolicyInput` as tensors, with a leading batch axis."""

    rows: Tensor
    ground: Tensor
    things: Tensor
    match: Tensor
    trace: Tensor
    state: Tensor

    def to(self, device: str) -> "PolicyBatch":
        """Copy the batch to a device."""
        return PolicyBatch(*(tensor.to(device) for tensor in self))


def batch_of(samples: list[PolicyInput]) -> PolicyBatch:
    """Stack inputs to a batch."""
    return tensors_of(PolicyInput(*(np.stack(part) for part in zip(*samples, strict=True))))


def tensors_of(sample: PolicyInput) -> PolicyBatch:
    """Convert inputs with a leading batch axis to tensors."""
    rows, *others = (torch.from_numpy(part) for part in sample)
    return PolicyBatch(rows.long(), *(other.float() for other in others))


def direction_bins(right: Tensor, ahead: Tensor) -> Tensor:
    """Encode directions as soft bins: weights of the two nearest of DIRECTIONS, (..., DIRECTIONS)."""
    place = torch.atan2(right, ahead) * (DIRECTIONS / (2.0 * math.pi))
    middles = torch.arange(DIRECTIONS, device=place.device)
    apart = torch.remainder(place[..., None] - middles + DIRECTIONS / 2, DIRECTIONS) - DIRECTIONS / 2
    return (1.0 - apart.abs()).clamp(min=0.0)


def soft_bins(values: Tensor, middles: tuple[float, ...]) -> Tensor:
    """Encode values as soft bins: weights of the two nearest centres, (..., centres)."""
    known = torch.tensor(middles, device=values.device)
    inside = values.clamp(middles[0], middles[-1]).contiguous()
    upper = torch.searchsorted(known, inside).clamp(1, len(middles) - 1)
    share = (inside - known[upper - 1]) / (known[upper] - known[upper - 1])
    found = torch.zeros(*values.shape, len(middles), device=values.device)
    found.scatter_(-1, upper[..., None], share[..., None])
    return found.scatter_add_(-1, upper[..., None] - 1, 1.0 - share[..., None])


class _Layer(nn.Module):
    """Pre-norm transformer layer with an attention bias between a row and the landmarks that match its names.

    Attribute names are tensor names in the shipped weights: `asked` is the query-key-value projection, `told` the
    output projection.
    """

    def __init__(self, sizes: PolicySizes) -> None:
        super().__init__()
        width = sizes.width
        self.heads = sizes.heads
        self.first, self.second = nn.LayerNorm(width), nn.LayerNorm(width)
        self.asked = nn.Linear(width, 3 * width)
        self.told = nn.Linear(width, width)
        self.inner = nn.Sequential(nn.Linear(width, sizes.inner), nn.GELU(), nn.Linear(sizes.inner, width))
        self.dropout = nn.Dropout(sizes.dropout)
        # Bias scale by head: of rows for landmarks, and of landmarks for rows, by first and second thing.
        self.bias = nn.Parameter(torch.linspace(0.0, 3.0, sizes.heads)[:, None].repeat(1, 4))

    def forward(self, tokens: Tensor, mask: Tensor, match: Tensor) -> Tensor:
        """Return the new tokens, (B, tokens, width).

        Args:
            tokens: (B, tokens, width), rows first, then landmarks.
            mask: padding mask, (B, 1, 1, tokens): MASKED_LOGIT for padding, else 0.
            match: match of landmarks with the names in rows, (B, 2, ROWS, THINGS).
        """
        batch, count, width = tokens.shape
        projected = self.asked(self.first(tokens)).view(batch, count, 3, self.heads, -1)
        query, key, value = projected.permute(2, 0, 3, 1, 4)
        bias = mask.expand(batch, self.heads, count, count).clone()
        by_row = torch.einsum("hk,bkrt->bhrt", self.bias[:, :2], match)
        by_thing = torch.einsum("hk,bkrt->bhtr", self.bias[:, 2:], match)
        bias[:, :, :ROWS, ROWS : ROWS + THINGS] += by_row
        bias[:, :, ROWS : ROWS + THINGS, :ROWS] += by_thing
        attended = functional.scaled_dot_product_attention(query, key, value, attn_mask=bias)
        tokens = tokens + self.dropout(self.told(attended.transpose(1, 2).reshape(batch, count, width)))
        output: Tensor = tokens + self.dropout(self.inner(self.second(tokens)))
        return output


class PolicyNetwork(nn.Module):
    """Predicts the best option, and the row that is being carried out.

    Attribute names are tensor names in the shipped weights.

    Args:
        sizes: sizes of the network.
    """

    def __init__(self, sizes: PolicySizes) -> None:
        super().__init__()
        self.sizes = sizes
        width = sizes.width
        self.slots = nn.ModuleList(nn.Embedding(len(values), width) for values in SLOTS.values())
        self.order = nn.Parameter(torch.randn(ROWS, width) * 0.1)
        self.bearing = nn.Parameter(torch.randn(DIRECTIONS, width) * 0.1)
        self.nearness = nn.Parameter(torch.randn(len(NEARNESS), width) * 0.1)
        self.age = nn.Parameter(torch.randn(len(AGES), width) * 0.1)
        described = THING_VALUES - 6 + 2 + len(NEARNESS) + len(AGES)
        self.thing = nn.Sequential(nn.Linear(described, width), nn.GELU(), nn.Linear(width, width))
        self.past = nn.Linear(2, width)
        self.began = nn.Parameter(torch.randn(width) * 0.1)
        self.ground = nn.Sequential(nn.Linear(len(RADII) * GROUND_CHANNELS, width), nn.GELU(), nn.Linear(width, width))
        self.state = nn.Linear(STATE_VALUES, width)
        self.layers = nn.ModuleList(_Layer(sizes) for _ in range(sizes.layers))
        self.progress = nn.Sequential(nn.LayerNorm(width), nn.Linear(width, 1))
        self.now = nn.Linear(2 * width, width)
        self.meant = nn.Linear(4, width)
        self.last = nn.LayerNorm(width)
        self.go = nn.Linear(width, len(DISTANCES))
        self.take = nn.Linear(width, 1)
        self.gate = nn.Parameter(torch.tensor([1.0, 0.0]))

    def forward(self, batch: PolicyBatch) -> Tensor:
        """Return the logits of all options, (B, OPTIONS)."""
        logits, _ = self.predict(batch)
        return logits

    def predict(self, batch: PolicyBatch) -> tuple[Tensor, Tensor]:
        """Return the logits of all options, (B, OPTIONS), and of the row that is being carried out, (B, ROWS)."""
        rows = sum(slot(batch.rows[:, :, number]) for number, slot in enumerate(self.slots)) + self.order
        tokens = torch.cat(
            [rows, self._things(batch.things), self._trace(batch.trace), self._ground(batch.ground),
             self.state(batch.state)[:, None]],
            1,
        )  # fmt: skip
        is_present = torch.cat(
            [
                batch.rows.any(2),
                batch.things[:, :, 0] > 0.0,
                batch.trace[:, :, 0] > 0.0,
                torch.ones(len(tokens), DIRECTIONS + 1, dtype=torch.bool, device=tokens.device),
            ],
            1,
        )
        mask = torch.where(is_present, 0.0, MASKED_LOGIT)[:, None, None]
        for layer in self.layers[:-1]:
            tokens = layer(tokens, mask, batch.match)
        progress = self.progress(tokens[:, :ROWS])[:, :, 0]
        progress = progress.masked_fill((batch.rows[:, :, 0] == 0) | (batch.rows[:, :, 0] == WHERE), MASKED_LOGIT)
        tokens = self.layers[-1](self._with_progress(tokens, progress.softmax(1), batch.match), mask, batch.match)
        return self._options(self.last(tokens), batch), progress

    def _with_progress(self, tokens: Tensor, shares: Tensor, match: Tensor) -> Tensor:
        """Add the row being carried out and its predecessor to all tokens, and their matches to the landmark tokens.

        Args:
            tokens: (B, tokens, width).
            shares: probabilities of the row that is being carried out, (B, ROWS).
            match: (B, 2, ROWS, THINGS).
        """
        both = torch.stack([shares, functional.pad(shares[:, 1:], (0, 1))], 1)  # (B, 2, ROWS)
        rows = (both @ tokens[:, :ROWS]).flatten(1)
        named = torch.einsum("bsr,bkrt->btsk", both, match).flatten(2)
        added = self.now(rows)[:, None].expand_as(tokens)
        meant = functional.pad(self.meant(named), (0, 0, ROWS, tokens.shape[1] - ROWS - THINGS))
        known: Tensor = tokens + added + meant
        return known

    def _options(self, tokens: Tensor, batch: PolicyBatch) -> Tensor:
        first = ROWS + THINGS + TRACE
        waypoints = self.go(tokens[:, first : first + DIRECTIONS]).flatten(1)
        # Only collectibles can be picked up; the better the match with the target, the higher the logit.
        collectible, match = batch.things[:, :, 6], batch.things[:, :, 10]
        gate = self.gate[0] * torch.log(match + 0.01) + self.gate[1]
        takes = self.take(tokens[:, ROWS : ROWS + THINGS])[:, :, 0] + gate
        takes = torch.where((collectible > 0.5) & (batch.things[:, :, 0] > 0.0), takes, MASKED_LOGIT)
        return torch.cat([waypoints, takes], 1)

    def _things(self, things: Tensor) -> Tensor:
        right, ahead, right_then, ahead_then, since = things[:, :, 1:6].unbind(2)
        then = torch.hypot(right_then, ahead_then)
        side = torch.stack([right_then, ahead_then], 2) / then.clamp(min=0.3)[:, :, None]
        described = torch.cat([things[:, :, 6:], side, soft_bins(then, NEARNESS), soft_bins(since, AGES)], 2)
        tokens: Tensor = self.thing(described) + self._where(right, ahead)
        return tokens

    def _trace(self, trace: Tensor) -> Tensor:
        right, ahead, sine, cosine, since = trace[:, :, 1:].unbind(2)
        tokens = self._where(right, ahead) + soft_bins(since, AGES) @ self.age
        tokens = tokens + self.past(torch.stack([sine, cosine], 2))
        began = torch.zeros_like(tokens)
        began[:, -1] = self.began
        return torch.add(tokens, began)

    def _ground(self, ground: Tensor) -> Tensor:
        tokens: Tensor = self.ground(ground.flatten(2)) + self.bearing
        return tokens

    def _where(self, right: Tensor, ahead: Tensor) -> Tensor:
        distance = torch.hypot(right, ahead)
        clear = (distance / 0.5).clamp(max=1.0)[..., None]  # Directions of things underfoot are meaningless.
        where: Tensor = (
            clear * direction_bins(right, ahead) @ self.bearing + soft_bins(distance, NEARNESS) @ self.nearness
        )
        return where

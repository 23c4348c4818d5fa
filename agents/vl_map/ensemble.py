"""Inference of several policy networks at once: their parameters are stacked, so that each layer is one operation.

The networks are so small that calling operations takes longer than computing them.

Shapes in comments: P networks, B batch size, T tokens, W embedding size.
"""

from collections.abc import Sequence
from typing import cast

import torch
from torch import Tensor, nn
from torch.nn import functional

from arramon_agents.vl_map.features import DIRECTIONS, ROWS, THINGS, TRACE
from arramon_agents.vl_map.network import (
    AGES,
    MASKED_LOGIT,
    NEARNESS,
    WHERE,
    PolicyBatch,
    PolicyNetwork,
    direction_bins,
    soft_bins,
)


class PolicyEnsemble:
    """Predicts what each of several trained `PolicyNetwork`s of one size predicts, up to rounding.

    Args:
        networks: trained networks, in evaluation mode; their parameters are copied.
    """

    def __init__(self, networks: Sequence[PolicyNetwork]) -> None:
        first = networks[0]
        self._heads, self._count = first.sizes.heads, len(networks)
        states = [network.state_dict() for network in networks]
        self._stacked = {name: torch.stack([state[name] for state in states]) for name in states[0]}
        self._layers = [f"layers.{number}" for number in range(first.sizes.layers)]
        # One table for the embeddings of all slots, and the place in it at which each slot begins.
        slots = [cast(nn.Embedding, slot).num_embeddings for slot in first.slots]
        tables = [self._stacked[f"slots.{number}.weight"] for number in range(len(slots))]
        self._table = torch.cat(tables, 1)  # (P, values of all slots, W)
        self._begin = torch.tensor([0, *slots[:-1]]).cumsum(0)
        for name in [name for name in self._stacked if name.endswith(".weight")]:
            if self._stacked[name].dim() == 3:
                self._stacked[name] = self._stacked[name].transpose(1, 2).contiguous()

    @torch.inference_mode()
    def __call__(self, batch: PolicyBatch) -> Tensor:
        """Return the logits of all options, (P, B, OPTIONS)."""
        tokens = torch.cat(
            [
                self._rows(batch.rows),
                self._things(batch.things),
                self._trace(batch.trace),
                self._ground(batch.ground),
                self._linear("state", self._for_each(batch.state))[:, :, None],
            ],
            2,
        )  # (P, B, T, W)
        is_present = torch.cat(
            [
                batch.rows.any(2),
                batch.things[:, :, 0] > 0.0,
                batch.trace[:, :, 0] > 0.0,
                torch.ones(len(batch.rows), DIRECTIONS + 1, dtype=torch.bool),
            ],
            1,
        )
        mask = torch.where(is_present, 0.0, MASKED_LOGIT)[:, None, None]  # (B, 1, 1, T)
        for layer in self._layers[:-1]:
            tokens = self._layer(layer, tokens, mask, batch.match)
        progress = self._linear("progress.1", self._norm("progress.0", tokens[:, :, :ROWS]))[..., 0]
        progress = progress.masked_fill((batch.rows[:, :, 0] == 0) | (batch.rows[:, :, 0] == WHERE), MASKED_LOGIT)
        tokens = self._with_progress(tokens, progress.softmax(2), batch.match)
        return self._options(self._norm("last", self._layer(self._layers[-1], tokens, mask, batch.match)), batch)

    def _for_each(self, values: Tensor) -> Tensor:
        """Repeat values, (B, ...), for each network, (P, B, ...), without copying them."""
        return values.expand(self._count, *values.shape)

    def _per_network(self, name: str, dimensions: int) -> Tensor:
        """Return a parameter, (P, ..., n), with axes of size 1 after the first, so that it has so many dimensions."""
        parameter = self._stacked[name]
        return parameter.view(self._count, *[1] * (dimensions - parameter.dim()), *parameter.shape[1:])

    def _linear(self, name: str, values: Tensor) -> Tensor:
        """Apply a linear layer of each network to its values, (P, ..., n)."""
        flat = values.reshape(self._count, -1, values.shape[-1])
        mapped = torch.baddbmm(self._stacked[f"{name}.bias"][:, None], flat, self._stacked[f"{name}.weight"])
        return mapped.view(*values.shape[:-1], -1)

    def _norm(self, name: str, values: Tensor) -> Tensor:
        """Apply a layer normalisation of each network to its values, (P, ..., n)."""
        scale, shift = (self._per_network(f"{name}.{part}", values.dim()) for part in ("weight", "bias"))
        return torch.addcmul(shift, functional.layer_norm(values, values.shape[-1:]), scale)

    def _two_layers(self, name: str, values: Tensor) -> Tensor:
        """Apply two linear layers with a GELU between them."""
        return self._linear(f"{name}.2", functional.gelu(self._linear(f"{name}.0", values)))

    def _layer(self, name: str, tokens: Tensor, mask: Tensor, match: Tensor) -> Tensor:
        """Return the new tokens, (P, B, T, W); arguments as for the layers of `PolicyNetwork`."""
        count, batch, length, width = tokens.shape
        projected = self._linear(f"{name}.asked", self._norm(f"{name}.first", tokens))
        query, key, value = projected.view(count * batch, length, 3, self._heads, -1).permute(2, 0, 3, 1, 4)
        bias = mask.expand(count, batch, self._heads, length, length).clone()
        scale = self._stacked[f"{name}.bias"]  # (P, heads, 4)
        things = slice(ROWS, ROWS + THINGS)
        bias[..., :ROWS, things] += torch.einsum("phk,bkrt->pbhrt", scale[:, :, :2], match)
        bias[..., things, :ROWS] += torch.einsum("phk,bkrt->pbhtr", scale[:, :, 2:], match)
        attended = functional.scaled_dot_product_attention(query, key, value, attn_mask=bias.flatten(0, 1))
        attended = attended.transpose(1, 2).reshape(count, batch, length, width)
        tokens = tokens + self._linear(f"{name}.told", attended)
        return tokens + self._two_layers(f"{name}.inner", self._norm(f"{name}.second", tokens))

    def _with_progress(self, tokens: Tensor, shares: Tensor, match: Tensor) -> Tensor:
        """Add the row being carried out and its predecessor; arguments as for `PolicyNetwork`, shares (P, B, ROWS)."""
        both = torch.stack([shares, functional.pad(shares[..., 1:], (0, 1))], 2)  # (P, B, 2, ROWS)
        rows = (both @ tokens[:, :, :ROWS]).flatten(2)
        named = torch.einsum("pbsr,bkrt->pbtsk", both, match).flatten(3)
        tokens = tokens + self._linear("now", rows)[:, :, None]
        tokens[:, :, ROWS : ROWS + THINGS] += self._linear("meant", named)
        return tokens

    def _options(self, tokens: Tensor, batch: PolicyBatch) -> Tensor:
        first = ROWS + THINGS + TRACE
        waypoints = self._linear("go", tokens[:, :, first : first + DIRECTIONS]).flatten(2)
        collectible, match = batch.things[:, :, 6], batch.things[:, :, 10]
        scale, shift = self._stacked["gate"][:, :, None, None].unbind(1)
        gate = scale * torch.log(match + 0.01) + shift
        takes = self._linear("take", tokens[:, :, ROWS : ROWS + THINGS])[..., 0] + gate
        takes = torch.where((collectible > 0.5) & (batch.things[:, :, 0] > 0.0), takes, MASKED_LOGIT)
        return torch.cat([waypoints, takes], 2)

    def _rows(self, rows: Tensor) -> Tensor:
        return self._table[:, rows + self._begin].sum(3) + self._per_network("order", 4)

    def _things(self, things: Tensor) -> Tensor:
        right, ahead, right_then, ahead_then, since = things[:, :, 1:6].unbind(2)
        then = torch.hypot(right_then, ahead_then)
        side = torch.stack([right_then, ahead_then], 2) / then.clamp(min=0.3)[:, :, None]
        described = torch.cat([things[:, :, 6:], side, soft_bins(then, NEARNESS), soft_bins(since, AGES)], 2)
        return self._two_layers("thing", self._for_each(described)) + self._where(right, ahead)

    def _trace(self, trace: Tensor) -> Tensor:
        right, ahead, sine, cosine, since = trace[:, :, 1:].unbind(2)
        tokens = self._where(right, ahead) + soft_bins(since, AGES) @ self._per_network("age", 4)
        tokens = tokens + self._linear("past", self._for_each(torch.stack([sine, cosine], 2)))
        tokens[:, :, -1] += self._stacked["began"][:, None]
        return tokens

    def _ground(self, ground: Tensor) -> Tensor:
        return self._two_layers("ground", self._for_each(ground.flatten(2))) + self._per_network("bearing", 4)

    def _where(self, right: Tensor, ahead: Tensor) -> Tensor:
        """Encode positions, (B, n), for each network, (P, B, n, W)."""
        distance = torch.hypot(right, ahead)
        clear = (distance / 0.5).clamp(max=1.0)[..., None]  # Directions of things underfoot are meaningless.
        bearings, nearness = self._per_network("bearing", 4), self._per_network("nearness", 4)
        return clear * direction_bins(right, ahead) @ bearings + soft_bins(distance, NEARNESS) @ nearness

"""Training targets and loss of the block network: the rarest category of thing in each block, from pixel labels."""

from collections.abc import Sequence
from functools import cache

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional

from arramon_agents.perception.eyes.network import BLOCKS, Predictions
from arramon_agents.perception.eyes.vocabulary import KINDS, NONE, SURFACES, Codes, codes_of, look_slices
from arramon_client.world import COLLECTIBLES, FURNITURE

WEIGHTS = {**dict.fromkeys(SURFACES, 0.5), **dict.fromkeys(FURNITURE, 1.0), **dict.fromkeys(COLLECTIBLES, 0.5)}
"""Class weights of kinds: most of a frame is street and buildings, and collectibles are named by another network."""

LOOK_WEIGHTS = {"facade": 1.0, "wall": 0.5, "pattern": 0.1, "shape": 0.2, "shop": 0.1}
"""Loss weights of looks, by group."""

MIN_BLOCK_SHARE = 0.04
"""Minimum share of a block's pixels that show a category for it to be in the block."""

_FIRST_THING, _FIRST_PROP = len(KINDS) - len(COLLECTIBLES), len(SURFACES)


class LabelTable:
    """Mapping from the simulator's labels to the encoder's vocabulary.

    Args:
        labels: (kind, colour, look) of each label of the segmentation, by index.

    Raises:
        ValueError: if a label is not in the vocabulary.
    """

    def __init__(self, labels: Sequence[tuple[str, str, str]]) -> None:
        self.codes = np.array([codes_of(*label) for label in labels], np.int64)
        kinds = self.codes[:, Codes._fields.index("kind")]
        self._ranks = np.select([kinds >= _FIRST_THING, kinds >= _FIRST_PROP], [2, 1], 0).astype(np.uint8)

    def blocks(self, labels: npt.NDArray[np.uint16]) -> npt.NDArray[np.int64]:
        """Return kind, colour and look of each block, (3, 28, 28), NONE for none.

        Collectibles take precedence over furniture, and furniture over all else, if they cover MIN_BLOCK_SHARE of it.

        Args:
            labels: (size, size), a segmentation.
        """
        side = len(labels) // BLOCKS
        pixels = labels.reshape(BLOCKS, side, BLOCKS, side).transpose(0, 2, 1, 3).reshape(BLOCKS, BLOCKS, -1)
        pixels = pixels[:, :, _from_middle(side)]
        ranks = self._ranks[pixels]
        shown = [(ranks == rank).mean(2) >= MIN_BLOCK_SHARE for rank in (2, 1)]
        rank = np.where(shown[0], 2, np.where(shown[1], 1, 0))
        chosen = (ranks == rank[:, :, None]).argmax(2)[:, :, None]
        label = np.take_along_axis(pixels, chosen, 2)[:, :, 0]
        return np.moveaxis(self.codes[label], 2, 0)


@cache
def _from_middle(side: int) -> npt.NDArray[np.int64]:
    """Return the indices of a block's pixels from the centre outwards; the first one with the chosen label counts."""
    offset = np.abs(np.arange(side) - (side - 1) / 2)
    return np.argsort(np.hypot(offset[:, None], offset[None]).ravel(), kind="stable")


def loss_of(predictions: Predictions, targets: Tensor) -> Tensor:
    """Return the loss: cross-entropies of kinds, of kinds among furniture, of colours, and of looks by group.

    Args:
        predictions: logits, (B, n, rows, columns) each.
        targets: (B, 3, rows, columns) int64 from `LabelTable.blocks`.
    """
    kinds, colours, looks = (part.permute(0, 2, 3, 1).flatten(0, 2) for part in predictions)
    kind, colour, look = (targets[:, number].flatten() for number in range(3))
    weights = torch.tensor([WEIGHTS[name] for name in KINDS])
    total = functional.cross_entropy(kinds, kind, weights)
    is_prop = (kind >= _FIRST_PROP) & (kind < _FIRST_THING)
    total = total + 0.3 * masked_cross_entropy(kinds[:, _FIRST_PROP:_FIRST_THING], kind - _FIRST_PROP, is_prop)
    total = total + 0.3 * masked_cross_entropy(colours, colour, colour != NONE)
    for name, places in look_slices().items():
        inside = (look >= places.start) & (look < places.stop)
        total = total + LOOK_WEIGHTS[name] * masked_cross_entropy(looks[:, places], look - places.start, inside)
    return total


def masked_cross_entropy(logits: Tensor, classes: Tensor, chosen: Tensor) -> Tensor:
    """Return the mean cross-entropy of the selected rows; 0 if there are none."""
    rows = chosen.nonzero().squeeze(1)
    if not len(rows):
        return logits.sum() * 0.0
    return functional.cross_entropy(logits[rows], classes[rows])

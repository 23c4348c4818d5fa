"""The encoder's grid of 7x7 cells: what is anywhere in each cell, and how near, from blocks and from named things."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional

from agents.learning.eyes.names import NamedThing
from agents.learning.eyes.network import BLOCKS, Predictions
from agents.learning.eyes.vocabulary import (
    BANNER_COLOURS,
    COLLECTIBLE_COLOURS,
    COLLECTIBLES,
    COLOURS,
    FURNITURE,
    FURNITURE_COLOURS,
    KINDS,
    LOOK_GROUPS,
    look_slices,
)

GRID = 7
"""Rows and columns of cells."""

GROUND = ("road", "pavement", "floor")

SHARE = 0.012
"""Share of a cell's pixels from which a thing is in it."""

THING_CHANNELS = (
    *(f"kind:{kind}" for kind in COLLECTIBLES),
    *(f"colour:{colour}" for colour in COLLECTIBLE_COLOURS),
    *(f"pattern:{look}" for look in LOOK_GROUPS[0].looks),
    "collectible",
    "nearness of collectible",
)
FURNITURE_CHANNELS = (
    *(f"furniture:{kind}" for kind in FURNITURE),
    *(f"furniture colour:{colour}" for colour in FURNITURE_COLOURS),
)
CHANNEL_NAMES = (
    *THING_CHANNELS,
    *FURNITURE_CHANNELS,
    *(f"banner colour:{colour}" for colour in BANNER_COLOURS),
    *(f"{group.name}:{look}" for group in LOOK_GROUPS[1:] for look in group.looks),
    "start_tile",
    "ground",
    "sky",
    "nearness",
    "mean nearness",
)
"""Meaning of each channel, in order. Nearness is 1 / (1 + depth in units)."""

_KIND = {kind: number for number, kind in enumerate(KINDS)}
_THINGS = slice(len(KINDS) - len(COLLECTIBLES), len(KINDS))
_PROPS = slice(_THINGS.start - len(FURNITURE), _THINGS.start)

Floats = npt.NDArray[np.float32]


class Probabilities(tuple[Tensor, Tensor, Tensor]):
    """Probabilities of kinds, of colours and of looks within their groups: (B, n, 28, 28) each."""

    __slots__ = ()


def probabilities(predictions: Predictions) -> Probabilities:
    """Return probabilities; those of looks add up to 1 in each group."""
    kinds, colours, looks = predictions
    groups = [looks[:, places].softmax(1) for places in look_slices().values()]
    return Probabilities((kinds.softmax(1), colours.softmax(1), torch.cat(groups, 1)))


def grid_of_blocks(found: Probabilities, depth: Tensor) -> Floats:
    """Return what is in each cell by the blocks, (B, 7, 7, channels) in [0, 1]; nothing in THING_CHANNELS.

    Args:
        found: probabilities by block.
        depth: (B, size, size) units, 0 where there is nothing.
    """
    kinds, colours, looks = found
    slices = look_slices()
    banner, props = kinds[:, _one("banner")], kinds[:, _PROPS].sum(1, keepdim=True)
    nearness = torch.where(depth > 0.0, 1.0 / (1.0 + depth), 0.0)[:, None]
    blocks = [
        kinds[:, _PROPS],
        (props - banner) * colours[:, [COLOURS.index(colour) for colour in FURNITURE_COLOURS]],
        banner * colours[:, [COLOURS.index(colour) for colour in BANNER_COLOURS]],
        banner * looks[:, slices["shape"]],
        kinds[:, _one("shop_sign")] * looks[:, slices["shop"]],
        kinds[:, _one("building")] * looks[:, slices["facade"]],
        kinds[:, _one("wall")] * looks[:, slices["wall"]],
        kinds[:, _one("start_tile")],
        kinds[:, [_KIND[kind] for kind in GROUND]].sum(1, keepdim=True),
        kinds[:, _one("nothing")],
        functional.max_pool2d(nearness, nearness.shape[-1] // BLOCKS),
    ]
    most = functional.max_pool2d(torch.cat(blocks, 1), BLOCKS // GRID)
    mean = functional.avg_pool2d(nearness, nearness.shape[-1] // GRID)
    cells = torch.cat([most, mean], 1).permute(0, 2, 3, 1).clamp(0.0, 1.0)
    return np.concatenate([np.zeros((*cells.shape[:3], len(THING_CHANNELS)), np.float32), cells.numpy()], 3)


def add_things(cells: Floats, things: Sequence[NamedThing], size: int) -> None:
    """Enter the named things of a frame into its grid.

    Args:
        cells: (7, 7, channels) of `grid_of_blocks`; changed.
        things: of the frame.
        size: side length of the frame, in pixels.
    """
    side = size // GRID
    first = len(THING_CHANNELS)
    last = first + len(FURNITURE_CHANNELS)
    for named in things:
        said = _thing_channels(named)
        furniture = _furniture_channels(named)
        for row, column in _cells_of(named, side):
            cell = cells[row, column]
            np.maximum(cell[:first], said, out=cell[:first])
            np.maximum(cell[first:last], furniture, out=cell[first:last])


def _thing_channels(named: NamedThing) -> Floats:
    chance = named.kinds[_THINGS].sum()
    near = 1.0 / (1.0 + named.thing.ahead) if chance > 0.5 else 0.0
    colours = chance * named.colours[: len(COLLECTIBLE_COLOURS)]
    return np.concatenate([named.kinds[_THINGS], colours, chance * named.patterns, [chance, near]]).astype(np.float32)


def _furniture_channels(named: NamedThing) -> Floats:
    kinds = named.kinds[_PROPS]
    chance = kinds.sum() - kinds[FURNITURE.index("banner")]
    colours = chance * named.colours[[COLOURS.index(colour) for colour in FURNITURE_COLOURS]]
    return np.concatenate([kinds, colours]).astype(np.float32)


def _cells_of(named: NamedThing, side: int) -> list[tuple[int, int]]:
    """Return the cells that a thing covers enough of; the fullest one at least."""
    rows, columns = np.nonzero(named.thing.mask)
    cells = (rows + named.thing.rows.start) // side * GRID + (columns + named.thing.columns.start) // side
    counts = np.bincount(cells, minlength=GRID * GRID)
    chosen = np.flatnonzero(counts >= min(SHARE * side * side, counts.max()))
    return [divmod(int(cell), GRID) for cell in chosen]


def _one(kind: str) -> slice:
    return slice(_KIND[kind], _KIND[kind] + 1)

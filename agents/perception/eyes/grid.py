"""Output features of the encoder: a grid of 7x7 cells with content and nearness, from blocks and detected things."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional

from arramon_agents.perception.encoder import GRID
from arramon_agents.perception.eyes.detected_things import DetectedThing
from arramon_agents.perception.eyes.network import BLOCKS, Probabilities
from arramon_agents.perception.eyes.vocabulary import (
    COLOURED,
    COLOURS,
    FURNITURE_COLOURS,
    KINDS,
    LOOK_GROUPS,
    look_slices,
)
from arramon_client.world import BANNER_COLOURS, COLLECTIBLE_COLOURS, COLLECTIBLES, FURNITURE

GROUND = ("road", "pavement", "floor")

MIN_CELL_SHARE = 0.012
"""Minimum share of a cell's pixels that a thing must cover to be in the cell."""

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
BOARD_CHANNELS = (
    *(f"banner colour:{colour}" for colour in BANNER_COLOURS),
    *(f"{group.name}:{look}" for group in LOOK_GROUPS[1:3] for look in group.looks),
)
NAMED_CHANNELS = (*THING_CHANNELS, *FURNITURE_CHANNELS, *BOARD_CHANNELS)
"""Channels set by cut-out things; only the channel of zebra crossings, which are flat, is set by blocks."""

CHANNEL_NAMES = (
    *NAMED_CHANNELS,
    *(f"{group.name}:{look}" for group in LOOK_GROUPS[3:] for look in group.looks),
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
_ZEBRA = CHANNEL_NAMES.index("furniture:zebra_crossing")
_COLOURED = [_KIND[kind] for kind in COLOURED]

Floats = npt.NDArray[np.float32]


def grid_of_blocks(found: Probabilities, depth: Tensor) -> Floats:
    """Pool block predictions to cells, (B, 7, 7, channels) in [0, 1]; of NAMED_CHANNELS only crossings are set.

    Args:
        found: probabilities by block.
        depth: (B, size, size) units, 0 where there is nothing.
    """
    kinds, _, looks = found
    slices = look_slices()
    nearness = torch.where(depth > 0.0, 1.0 / (1.0 + depth), 0.0)[:, None]
    blocks = [
        kinds[:, _one("zebra_crossing")],
        kinds[:, _one("building")] * looks[:, slices["facade"]],
        kinds[:, _one("wall")] * looks[:, slices["wall"]],
        kinds[:, _one("start_tile")],
        kinds[:, [_KIND[kind] for kind in GROUND]].sum(1, keepdim=True),
        kinds[:, _one("nothing")],
        functional.max_pool2d(nearness, nearness.shape[-1] // BLOCKS),
    ]
    most = functional.max_pool2d(torch.cat(blocks, 1), BLOCKS // GRID)
    mean = functional.avg_pool2d(nearness, nearness.shape[-1] // GRID)
    cells = torch.cat([most, mean], 1).permute(0, 2, 3, 1).clamp(0.0, 1.0).numpy()
    filled = np.zeros((*cells.shape[:3], len(CHANNEL_NAMES)), np.float32)
    filled[..., _ZEBRA] = cells[..., 0]
    filled[..., len(NAMED_CHANNELS) :] = cells[..., 1:]
    return filled


def add_things(cells: Floats, things: Sequence[DetectedThing], size: int) -> None:
    """Add the detected things of a frame to its grid, in place.

    Args:
        cells: (7, 7, channels) from `grid_of_blocks`, changed.
        things: detected things of the frame.
        size: side length of the frame, in pixels.
    """
    for named in things:
        values = _channel_values(named)
        for row, column in _cells_of(named, size // GRID):
            cell = cells[row, column, : len(NAMED_CHANNELS)]
            np.maximum(cell, values, out=cell)


def _channel_values(named: DetectedThing) -> Floats:
    """Return the values of the named channels for a thing."""
    kinds, colours, looks = named.kinds, named.colours, named.looks
    collectible = kinds[_THINGS].sum()
    banner, sign = kinds[_KIND["banner"]], kinds[_KIND["shop_sign"]]
    furniture = kinds[_COLOURED].sum()
    slices = look_slices()
    return np.concatenate(
        [
            kinds[_THINGS],
            collectible * colours[: len(COLLECTIBLE_COLOURS)],
            collectible * looks[slices["pattern"]],
            [collectible, 1.0 / (1.0 + named.thing.ahead) if collectible > 0.5 else 0.0],
            kinds[_PROPS],
            furniture * colours[[COLOURS.index(colour) for colour in FURNITURE_COLOURS]],
            banner * colours[[COLOURS.index(colour) for colour in BANNER_COLOURS]],
            banner * looks[slices["shape"]],
            sign * looks[slices["shop"]],
        ]
    ).astype(np.float32)


def _cells_of(named: DetectedThing, side: int) -> list[tuple[int, int]]:
    """Return the cells of which a thing covers a share of at least MIN_CELL_SHARE, or else the cell it covers most."""
    rows, columns = np.nonzero(named.thing.mask)
    cells = (rows + named.thing.rows.start) // side * GRID + (columns + named.thing.columns.start) // side
    counts = np.bincount(cells, minlength=GRID * GRID)
    chosen = np.flatnonzero(counts >= min(MIN_CELL_SHARE * side * side, counts.max()))
    return [divmod(int(cell), GRID) for cell in chosen]


def _one(kind: str) -> slice:
    return slice(_KIND[kind], _KIND[kind] + 1)

"""The names of things as the networks see and read them: kinds, colours and looks, from the features of a cell."""

from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from agents.learning.eyes.grid import CHANNEL_NAMES
from agents.learning.eyes.vocabulary import COLLECTIBLES, COLOURS, FURNITURE, LOOK_GROUPS

FACADES = next(group.looks for group in LOOK_GROUPS if group.name == "facade")

KINDS = ("collectible", *COLLECTIBLES, *FURNITURE, "building", *(f"{look} building" for look in FACADES), "start_tile")
"""Kinds; the first and "building" stand for any of theirs."""

LOOKS = tuple((group.name, look) for group in LOOK_GROUPS[:3] for look in group.looks)
"""Patterns of collectibles, shapes of banners, names of shops."""

_PLACES = {name: number for number, name in enumerate(CHANNEL_NAMES)}
_NOTHING = len(CHANNEL_NAMES)
"""The place of a channel that is always 0."""


class Named(NamedTuple):
    """What is in each of N places: kinds (..., N, K), colours (..., N, C) and looks (..., N, L), in [0, 1]."""

    kinds: Tensor
    colours: Tensor
    looks: Tensor


def named(cells: Tensor) -> Named:
    """Return what the visual encoder "eyes" has named in each cell.

    Args:
        cells: its features, (..., N, C).
    """
    cells = torch.nn.functional.pad(cells, (0, 1))
    return Named(*(cells[..., table.to(cells.device)].amax(-1) for table in _TABLES))


def _table(channels: Sequence[Sequence[str]]) -> Tensor:
    """Return the places of each name's channels, (names, most); a name has its largest."""
    most = max(map(len, channels))
    return torch.tensor([[*(_PLACES[name] for name in names), *[_NOTHING] * (most - len(names))] for names in channels])


def _channels_of(colour: str) -> list[str]:
    names = (f"{of} colour:{colour}" if of else f"colour:{colour}" for of in ("", "furniture", "banner"))
    return [name for name in names if name in _PLACES]


_FACADE_CHANNELS = [f"facade:{look}" for look in FACADES]
_TABLES = (
    _table(
        [
            ["collectible"],
            *([f"kind:{kind}"] for kind in COLLECTIBLES),
            *([f"furniture:{kind}"] for kind in FURNITURE),
            _FACADE_CHANNELS,
            *([name] for name in _FACADE_CHANNELS),
            ["start_tile"],
        ]
    ),
    _table([_channels_of(colour) for colour in COLOURS]),
    _table([[f"{group}:{look}"] for group, look in LOOKS]),
)

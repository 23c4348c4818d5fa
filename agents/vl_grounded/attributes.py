"""Attributes of things, the networks' interface between words and vision: kinds, colours and looks seen in a cell."""

from collections.abc import Iterable
from typing import NamedTuple

import torch
from torch import Tensor

from arramon_agents.perception.eyes.grid import CHANNEL_NAMES
from arramon_agents.perception.eyes.vocabulary import COLOURS, LOOK_GROUPS
from arramon_client.world import COLLECTIBLES, FURNITURE

FACADES = next(group.looks for group in LOOK_GROUPS if group.name == "facade")

KINDS = ("collectible", *COLLECTIBLES, *FURNITURE, "building", *(f"{look} building" for look in FACADES), "start_tile")
"""Kinds; "collectible" and "building" are true for every collectible and for every facade."""

LOOKS = tuple((group.name, look) for group in LOOK_GROUPS[:3] for look in group.looks)
"""Patterns of collectibles, shapes of banners, names of shops."""


class Attributes(NamedTuple):
    """Attributes seen in each of N places: kinds (..., N, K), colours (..., N, C), looks (..., N, L), in [0, 1]."""

    kinds: Tensor
    colours: Tensor
    looks: Tensor

    def to(self, device: str) -> "Attributes":
        """Copy the attributes to a device."""
        return Attributes(*(tensor.to(device) for tensor in self))


def attributes_of(cells: Tensor) -> Attributes:
    """Return the attributes that the visual encoder "eyes" sees in each cell.

    Args:
        cells: features of the encoder, (..., N, channels).
    """
    building = cells[..., _FACADES].amax(-1, keepdim=True)
    cells = torch.cat([cells, building, torch.zeros_like(building)], -1)
    colours = [cells.index_select(-1, each.to(cells.device)) for each in _COLOURS]
    return Attributes(
        cells.index_select(-1, _KINDS.to(cells.device)),
        torch.stack(colours).amax(0),
        cells.index_select(-1, _LOOKS.to(cells.device)),
    )


_PLACES = {name: number for number, name in enumerate((*CHANNEL_NAMES, "building", "nothing"))}
_FACADES = [_PLACES[f"facade:{look}"] for look in FACADES]


def _table(names: Iterable[str]) -> Tensor:
    """Return the indices of channels by name; a name without a channel gets one that is 0 everywhere."""
    return torch.tensor([_PLACES.get(name, _PLACES["nothing"]) for name in names])


_KINDS = _table(
    [
        "collectible",
        *(f"kind:{kind}" for kind in COLLECTIBLES),
        *(f"furniture:{kind}" for kind in FURNITURE),
        "building",
        *(f"facade:{look}" for look in FACADES),
        "start_tile",
    ]
)
_COLOURS = [_table(f"{of}colour:{colour}" for colour in COLOURS) for of in ("", "furniture ", "banner ")]
_LOOKS = _table(f"{group}:{look}" for group, look in LOOKS)

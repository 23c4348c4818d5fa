"""Vocabulary of the encoder: kinds, colours and looks, whose combinations are the simulator's labels."""

from typing import NamedTuple

from arramon_client.world import (
    BANNER_SHAPES,
    COLLECTIBLE_COLOURS,
    COLLECTIBLE_PATTERNS,
    COLLECTIBLES,
    FACADES,
    FURNITURE,
    SHOPS,
    WALLS,
)

SURFACES = ("nothing", "road", "pavement", "roof", "floor", "start_tile", "ceiling", "wall", "building")

KINDS = (*SURFACES, *FURNITURE, *COLLECTIBLES)
COLOURS = (*COLLECTIBLE_COLOURS, "black", "orange", "silver", "concrete", "gold")
FURNITURE_COLOURS = ("orange", "red", "blue", "green", "silver", "concrete", "white", "yellow", "gold")

COLOURED = ("cone", "dumpster", "barrier", "barrel", "car", "kiosk", "awning")
"""Furniture that comes in several colours, without banners."""


class LookGroup(NamedTuple):
    """A group of mutually exclusive looks, and the kinds that have them.

    Attributes:
        name: name of the group, such as "pattern".
        kinds: kinds of things that have these looks.
        looks: names of the looks.
    """

    name: str
    kinds: tuple[str, ...]
    looks: tuple[str, ...]


LOOK_GROUPS = (
    LookGroup("pattern", COLLECTIBLES, COLLECTIBLE_PATTERNS),
    LookGroup("shape", ("banner",), BANNER_SHAPES),
    LookGroup("shop", ("shop_sign",), SHOPS),
    LookGroup("facade", ("building",), FACADES),
    LookGroup("wall", ("wall",), WALLS),
)
LOOKS = tuple((group.name, look) for group in LOOK_GROUPS for look in group.looks)

NONE = -1
"""Code of a missing colour or look."""


class Codes(NamedTuple):
    """A label as indices in KINDS, COLOURS and LOOKS, or NONE."""

    kind: int
    colour: int
    look: int


def codes_of(kind: str, colour: str, look: str) -> Codes:
    """Return the codes of a label.

    Raises:
        ValueError: if kind, colour or look is not in the vocabulary.
    """
    group = next((group for group in LOOK_GROUPS if kind in group.kinds), None)
    if look and group is None:
        raise ValueError(f"a {kind} has no look, not {look!r}")
    return Codes(
        KINDS.index(kind),
        COLOURS.index(colour) if colour else NONE,
        LOOKS.index((group.name, look)) if look and group is not None else NONE,
    )


def look_slices() -> dict[str, slice]:
    """Return the slice of LOOKS of each look group."""
    slices, first = {}, 0
    for group in LOOK_GROUPS:
        slices[group.name] = slice(first, first + len(group.looks))
        first += len(group.looks)
    return slices

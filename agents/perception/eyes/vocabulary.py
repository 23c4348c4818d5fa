"""The encoder's vocabulary: kinds, colours and looks, of which the simulator's labels are combinations."""

from typing import NamedTuple

SURFACES = ("nothing", "road", "pavement", "roof", "floor", "start_tile", "ceiling", "wall", "building")
FURNITURE = (
    "cone", "phone_booth", "bench", "lamp_post", "traffic_light", "dumpster", "barrier", "barrel", "tyre_stack",
    "hydrant", "mailbox", "bin", "bags", "tree", "stop_sign", "speed_sign", "banner", "car", "kiosk", "planter",
    "awning", "shop_sign", "zebra_crossing",
)  # fmt: skip
COLLECTIBLES = ("ball", "hourglass", "mug", "tv", "book", "bowl", "bucket")

KINDS = (*SURFACES, *FURNITURE, *COLLECTIBLES)
COLOURS = (
    "green", "red", "blue", "white", "yellow", "brown", "purple", "black", "orange", "silver", "concrete", "gold",
)  # fmt: skip

COLLECTIBLE_COLOURS = COLOURS[:7]
BANNER_COLOURS = ("red", "blue", "green", "yellow", "white", "black")
FURNITURE_COLOURS = ("orange", "red", "blue", "green", "silver", "concrete", "white", "yellow", "gold")

COLOURED = ("cone", "dumpster", "barrier", "barrel", "car", "kiosk", "awning")
"""Furniture of several colours, besides banners."""


class LookGroup(NamedTuple):
    """A group of mutually exclusive looks, and the kinds that have them.

    Attributes:
        name: of the property, such as the pattern.
        kinds: which have these looks.
        looks: their names.
    """

    name: str
    kinds: tuple[str, ...]
    looks: tuple[str, ...]


LOOK_GROUPS = (
    LookGroup("pattern", COLLECTIBLES, ("dotted", "striped")),
    LookGroup("shape", ("banner",), ("star", "diamond", "triangle", "circle", "hexagon", "dot")),
    LookGroup("shop", ("shop_sign",), ("hotel", "cafe", "bank", "bakery", "pharmacy", "cinema")),
    LookGroup(
        "facade",
        ("building",),
        ("brick", "brown", "concrete", "glass", "white", "arched", "red", "grey", "yellow", "green", "blue"),
    ),
    LookGroup("wall", ("wall",), ("wood", "brick", "spotted", "striped")),
)
LOOKS = tuple((group.name, look) for group in LOOK_GROUPS for look in group.looks)

NONE = -1
"""Code of a missing colour or look."""


class Codes(NamedTuple):
    """A label as codes: indices in KINDS, COLOURS and LOOKS, or NONE."""

    kind: int
    colour: int
    look: int


def codes_of(kind: str, colour: str, look: str) -> Codes:
    """Return the codes of a label.

    Raises:
        ValueError: for a kind, colour or look that is not in the vocabulary.
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

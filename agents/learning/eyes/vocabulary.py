"""What the encoder can name: kinds, colours and looks, factorised; the simulator's labels are combinations of them."""

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
    """Looks that exclude each other, of the kinds that have them.

    Attributes:
        name: of what varies.
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
"""The number of a colour or a look that a label does not have."""


class Codes(NamedTuple):
    """A label as numbers: places in KINDS, COLOURS and LOOKS, or NONE."""

    kind: int
    colour: int
    look: int


def codes_of(kind: str, colour: str, look: str) -> Codes:
    """Return the numbers of a label.

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
    """Return by look group its places in LOOKS."""
    slices, first = {}, 0
    for group in LOOK_GROUPS:
        slices[group.name] = slice(first, first + len(group.looks))
        first += len(group.looks)
    return slices

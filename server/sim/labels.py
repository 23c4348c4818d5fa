"""Segmentation labels: one fixed table for all sections and the room."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from arramon_client.world import BANNER_COLOURS, BANNER_SHAPES, FACADES, FURNITURE, SHOPS, WALLS
from arramon_server.sim.assets.furniture import COLOURS, IMPORTED_COLOURS
from arramon_server.sim.catalogue import ALL_TYPES, ObjectType

IMPORTED_BANNER_COLOURS = ("orange", "brown")
"""Further colours of banners, from people's instructions in imported texts."""


@dataclass(frozen=True, slots=True, order=True)
class SegmentationLabel:
    """A visually distinguishable kind of object or surface.

    Attributes:
        kind: "nothing" (the sky), "road", "pavement", "roof", "building", a kind of `section.PROP_KINDS`, a
            collectible's kind, "wall", "floor", "ceiling" or "start_tile".
        colour: a collectible's colour, a banner's background colour, or the colour of furniture of a kind with several;
            otherwise "".
        look: a collectible's pattern, a banner's shape, a sign's shop, a building's facade or a wall's look; otherwise
            "".
    """

    kind: str
    colour: str = ""
    look: str = ""

    @classmethod
    def of(cls, type_: ObjectType) -> "SegmentationLabel":
        """Return the label of a collectible."""
        return cls(type_.kind, type_.colour, type_.pattern)

    def __str__(self) -> str:
        """Return the label as in `scene.Body`: "building//brick", "cone/orange", "road"."""
        return f"{self.kind}/{self.colour}/{self.look}".rstrip("/")


_SHAPED = ("banner", "shop_sign")

NOTHING = SegmentationLabel("nothing")
"""Label of the sky."""

LABELS: tuple[SegmentationLabel, ...] = (
    NOTHING,
    SegmentationLabel("road"),
    SegmentationLabel("pavement"),
    SegmentationLabel("roof"),
    SegmentationLabel("floor"),
    SegmentationLabel("start_tile"),
    SegmentationLabel("ceiling"),
    *(SegmentationLabel("wall", look=look) for look in WALLS),
    *(SegmentationLabel("building", look=look) for look in FACADES),
    *(SegmentationLabel("banner", colour, shape) for colour, shape in product(BANNER_COLOURS, BANNER_SHAPES)),
    *(
        SegmentationLabel(kind, colour)
        for kind in FURNITURE
        if kind not in _SHAPED
        for colour in COLOURS.get(kind, ("",))
    ),
    *(SegmentationLabel("shop_sign", look=shop) for shop in SHOPS),
    *(SegmentationLabel.of(type_) for type_ in ALL_TYPES),
    # At the end: what is learned of the labels before keeps its numbers.
    *(SegmentationLabel(kind, colour) for kind in FURNITURE for colour in IMPORTED_COLOURS.get(kind, ())),
    *(SegmentationLabel("banner", colour, shape) for colour, shape in product(IMPORTED_BANNER_COLOURS, BANNER_SHAPES)),
)
"""All labels; a segmentation's numbers are indices into this table."""

_PLACES = {
    **{str(label): i for i, label in enumerate(LABELS)},
    **{str(t): LABELS.index(SegmentationLabel.of(t)) for t in ALL_TYPES},
}


def places_of(labels: Sequence[str]) -> npt.NDArray[np.uint16]:
    """Return (n,): the index in LABELS of each of a camera's n labels, to convert its segmentation to this table.

    Raises:
        KeyError: for a label that is not in the table.
    """
    return np.array([_PLACES[label] for label in labels], dtype=np.uint16)

"""Sections of the city as plain data, from which scenes are built."""

from dataclasses import dataclass

ON_WALLS = frozenset({"banner", "awning", "shop_sign"})
"""Kinds that hang on a wall, above the heads of agents or flat against it."""


@dataclass(frozen=True, slots=True)
class Building:
    """A box with four facades and a flat roof.

    Attributes:
        x, z: centre, in units.
        half_width: half its extent along its own x axis, in units.
        half_length: half its extent along its own z axis, in units.
        heading: direction of its own z axis, degrees clockwise from +z.
        height: height, in units.
        facade: one of FACADES.
    """

    x: float
    z: float
    half_width: float
    half_length: float
    heading: float
    height: float
    facade: str


@dataclass(frozen=True, slots=True)
class Prop:
    """A piece of street furniture.

    Attributes:
        kind: one of PROP_KINDS.
        x, z: position, in units; for a kind in ON_WALLS, a point on the wall.
        heading: direction of its front, degrees clockwise from +z; of a zebra crossing, that of the street.
        colour: colour of kinds with several (`assets.furniture.COLOURS`; a banner's background colour), otherwise "".
        shape: a banner's star, diamond, triangle, circle, hexagon or dot; what a shop's sign is for, one of
            `assets.signs.SHOPS`; otherwise "".
        shape_colour: colour of a banner's shape; otherwise "".
    """

    kind: str
    x: float
    z: float
    heading: float
    colour: str = ""
    shape: str = ""
    shape_colour: str = ""


@dataclass(frozen=True, slots=True)
class Section:
    """One of the city's disjoint sections.

    Attributes:
        id: identifier, for example "1".
        heading: direction of the main streets, degrees clockwise from +z.
        bounds: (x from, z from, x to, z to) of the ground that agents can reach, in units.
    """

    id: str
    heading: float
    bounds: tuple[float, float, float, float]
    buildings: tuple[Building, ...]
    props: tuple[Prop, ...]

"""What a section of the city is made of: plain data, from which the scene and the obstacles follow."""

from dataclasses import dataclass

FACADES = ("brick", "brown", "concrete", "glass", "white", "arched", "red", "grey")
"""Looks of a building's walls."""

PROP_KINDS = (
    "cone", "phone_booth", "bench", "lamp_post", "traffic_light", "dumpster", "barrier", "barrel", "tyre_stack",
    "hydrant", "mailbox", "bin", "bags", "tree", "stop_sign", "speed_sign", "banner",
)  # fmt: skip
"""Street furniture. A banner hangs on a wall; everything else stands on the ground."""


@dataclass(frozen=True, slots=True)
class Building:
    """A box with four facades and a flat roof.

    Attributes:
        x, z: its centre, in units.
        half_width: half its extent along its own x axis, in units.
        half_length: half its extent along its own z axis, in units.
        heading: of its own z axis, degrees clockwise from +z.
        height: in units.
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
        x, z: where it stands, in units; of a banner, a point on the wall that it hangs on.
        heading: where its front faces, degrees clockwise from +z.
        colour: where the kind comes in several (cone: orange, red, blue; dumpster: green, silver; barrier: concrete,
            white, red; barrel: red, yellow, gold; banner: its ground colour), otherwise "".
        shape: of a banner: star, diamond, triangle, circle, hexagon or dot; otherwise "".
        shape_colour: of a banner; otherwise "".
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
        id: such as "1".
        heading: direction of the main streets, degrees clockwise from +z.
        bounds: (x from, z from, x to, z to) of the ground that agents can reach, in units.
    """

    id: str
    heading: float
    bounds: tuple[float, float, float, float]
    buildings: tuple[Building, ...]
    props: tuple[Prop, ...]

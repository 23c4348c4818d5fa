"""Puts street furniture and banners into a section that was rebuilt from paths.

How often each kind stands in the streets follows how often the instructions of the original benchmark name it.
"""

from collections.abc import Sequence
from random import Random

import numpy as np

from server.episodes.chance import seeded
from server.episodes.grid import Points
from server.episodes.setting import Setting, candidates, extents, free_of_others
from server.sim import furniture
from server.sim.section import Building, Prop

COUNTS = {
    "dumpster": 6, "phone_booth": 7, "bench": 8, "barrier": 6, "tree": 5, "tyre_stack": 2, "bags": 2, "mailbox": 3,
    "bin": 5, "barrel": 6, "traffic_light": 5, "stop_sign": 2, "speed_sign": 2, "lamp_post": 9, "hydrant": 4,
    "cone": 14, "banner": 10,
}  # fmt: skip
"""How many of each kind a section gets where there is room, the bulky ones first."""

COLOURS = {
    **furniture.COLOURS,
    "cone": ("orange", "orange", "red", "blue"),
    "banner": ("red", "blue", "green", "yellow", "white", "black"),
}
"""What each kind is drawn from: the likelier ones more than once."""

SHAPES = ("star", "star", "diamond", "diamond", "triangle", "hexagon", "circle", "dot")
SHAPE_COLOURS = {
    "red": ("white", "yellow", "black"), "blue": ("white", "yellow", "red"), "green": ("white", "yellow", "red"),
    "yellow": ("red", "blue", "black"), "white": ("red", "blue", "green"), "black": ("white", "yellow", "red"),
}  # fmt: skip
"""Of a banner, by its ground colour."""


def furnish(
    section_id: str, heading: float, buildings: Sequence[Building], trodden: Points, targets: Points
) -> tuple[Prop, ...]:
    """The section's furniture; the same input gives the same.

    Args:
        section_id: draws what stands where.
        heading: of the streets, degrees clockwise from +z.
        buildings: of the section.
        trodden: (n, 2) of (x, z): points close together along every path.
        targets: (m, 2) of (x, z).
    """
    setting = Setting.of(heading, buildings, trodden, targets)
    random = seeded(section_id, "furniture")
    for kind, count in COUNTS.items():
        places, fronts = candidates(setting, kind, random)
        for _ in range(count):
            place(setting, kind, places, fronts, random)
    return tuple(setting.placed)


def place(setting: Setting, kind: str, places: Points, fronts: Points, random: Random) -> None:
    """Adds one thing of this kind, far from others of its kind, unless there is no room left."""
    room = free_of_others(setting, places, max(extents(kind)))
    chosen = np.flatnonzero(room)
    if not len(chosen):
        return
    tried = [int(chosen[random.randrange(len(chosen))]) for _ in range(6)]
    same = [spot for spot, prop in zip(setting.spots, setting.placed, strict=True) if prop.kind == kind]
    best = max(tried, key=lambda i: min((np.hypot(*(places[i] - spot[:2])) for spot in same), default=0.0))
    colour = random.choice(COLOURS.get(kind, ("",)))
    shape = random.choice(SHAPES) if kind == "banner" else ""
    shape_colour = random.choice(SHAPE_COLOURS[colour]) if kind == "banner" else ""
    setting.add(kind, places[best], float(fronts[best]), (colour, shape, shape_colour))

"""Sections reconstructed from paths with random street furniture, as a baseline for furniture recovered from texts.

The number of each kind follows the frequency with which the original benchmark's instructions mention it.
"""

from collections.abc import Sequence
from dataclasses import replace
from random import Random

import numpy as np

from arramon_dataset.layout.furniture_colours import COLOURS, SHAPE_COLOURS
from arramon_dataset.layout.grid import Points, sample_points
from arramon_dataset.layout.prop_places import Surroundings, candidate_places, half_size, is_free_of_others
from arramon_dataset.randomness import seeded
from arramon_dataset.release.reconstruction import reconstruct_section
from arramon_server.sim.section import Building, Prop, Section

COUNTS = {
    "dumpster": 6, "phone_booth": 7, "bench": 8, "barrier": 6, "tree": 5, "tyre_stack": 2, "bags": 2, "mailbox": 3,
    "bin": 5, "barrel": 6, "traffic_light": 5, "stop_sign": 2, "speed_sign": 2, "lamp_post": 9, "hydrant": 4,
    "cone": 14, "banner": 10,
}  # fmt: skip
"""Number of each kind in a section, where there is room; bulky kinds are placed first."""

SHAPES = ("star", "star", "diamond", "diamond", "triangle", "hexagon", "circle", "dot")
"""Shapes of banners; likelier ones are repeated."""


def reconstruct(section_id: str, paths: Sequence[Points], targets: Points) -> Section:
    """Return the section of `reconstruct_section` with drawn furniture, none of which blocks a path.

    Args, Raises: as for `reconstruct_section`; the id seeds the furniture, too.
    """
    built = reconstruct_section(section_id, paths, targets)
    return replace(built, props=furnish(section_id, built.heading, built.buildings, sample_points(paths), targets))


def furnish(
    section_id: str, heading: float, buildings: Sequence[Building], walked: Points, targets: Points
) -> tuple[Prop, ...]:
    """Return the section's furniture; the same input gives the same result.

    Args:
        section_id: seeds the placement.
        heading: of the streets, degrees clockwise from +z.
        buildings: of the section.
        walked: (n, 2) of (x, z): closely spaced points on all paths.
        targets: (m, 2) of (x, z).
    """
    surroundings = Surroundings.of(heading, buildings, walked, targets)
    random = seeded(section_id, "furniture")
    for kind, count in COUNTS.items():
        places, fronts = candidate_places(surroundings, kind, random)
        for _ in range(count):
            place_prop(surroundings, kind, places, fronts, random)
    return tuple(surroundings.placed)


def _apart(place: Points, spot: Sequence[float]) -> float:
    return float(np.hypot(place[0] - spot[0], place[1] - spot[1]))


def place_prop(surroundings: Surroundings, kind: str, places: Points, fronts: Points, random: Random) -> None:
    """Place one prop of this kind far from others of its kind, if there is room."""
    room = is_free_of_others(surroundings, places, max(half_size(kind)))
    chosen = np.flatnonzero(room)
    if not len(chosen):
        return
    tried = [int(chosen[random.randrange(len(chosen))]) for _ in range(6)]
    same = [spot for spot, prop in zip(surroundings.spots, surroundings.placed, strict=True) if prop.kind == kind]
    best = max(tried, key=lambda i: min((_apart(places[i], spot) for spot in same), default=0.0))
    colour = random.choice(COLOURS.get(kind, ("",)))
    shape = random.choice(SHAPES) if kind == "banner" else ""
    shape_colour = random.choice(SHAPE_COLOURS[colour]) if kind == "banner" else ""
    surroundings.add(kind, places[best], float(fronts[best]), (colour, shape, shape_colour))

"""Builds up what a plan's streets leave: buildings along every street, facing it, and no gap that leads outside."""

import math
from dataclasses import dataclass, field
from random import Random

import numpy as np
from scipy import ndimage

from server.episodes.chance import seeded
from server.episodes.grid import CELL, Grid, Mask, Points
from server.episodes.plans.plan import Plan
from server.episodes.plans.strips import Surface, surface
from server.episodes.reconstruct import RING, around, filled, reached, set_back, within
from server.episodes.rectangles import Rectangle, cover, split
from server.sim.markings import covers
from server.sim.section import FACADES, Building

SHORTEST, LONGEST = 3.5, 7.5
"""Sides of a lot, in units, where the ground is wide enough."""

NARROWEST = 1.5
"""Ground that holds no lot of this many units each way stays empty, unless it lies deep between the lots."""

DEEP = 1.0
"""What is farther than this from every street is built up to the last corner, in units."""

OVERLAP = 1.5
"""How far lots along one street reach behind the lots along another, in units: so they leave no gap between them."""

SETBACKS = (0.0, 0.0, 0.0, 0.25, 0.5)
"""How far a facade may stand back from the edge of the street, in units."""

THICKEN = 1.0
"""How far what fills a gap reaches behind its neighbours, in units."""

HEIGHTS = ((1.6, 2.6), (2.6, 4.4), (4.4, 6.5), (6.5, 9.0))
"""Of buildings, in units: as often short as tall."""

NEAR = 9.0
"""Buildings whose middles are nearer than this differ in facade, as far as there are facades enough, in units."""


@dataclass
class Layer:
    """The ground as seen along one heading: a raster, and the lots along its axes.

    Attributes:
        grid: turned to the heading.
        street: what streets cover.
        own: what is built up and lies nearest to a street of this heading.
        lots: on `own` ground.
    """

    grid: Grid
    street: Mask
    own: Mask
    lots: list[Rectangle] = field(default_factory=list)


def build_up(plan: Plan, seed: str) -> tuple[Building, ...]:
    """The section's buildings; the same plan and seed give the same.

    Their places follow from the plan alone; what they look like from the seed as well.

    Args:
        plan: where the streets are.
        seed: draws heights and facades.
    """
    ground = surface(plan)
    layers = [survey(ground, heading) for heading in ground.headings]
    for layer in layers:
        layer.lots = lots_of(plan, layer)
    base = survey(ground, plan.heading % 90.0)
    gaps = ~base.street & within(base.street, RING) & ~standing(base.grid, boxes(layers)) & ~near(base.street, DEEP)
    base.lots = [thickened(gap, base.street) for gap in cover(gaps, 1)]
    layers.append(base)
    for number, layer in enumerate(layers):
        layer.lots = stand_back(plan, number, layer, layers)
    return tuple(dressed(plan, seed, boxes(layers)))


def survey(ground: Surface, heading: float) -> Layer:
    """The ground along one heading, without lots. Its own ground is all where no street has this heading."""
    grid = Grid.around(ground.corners(), heading, RING + CELL)
    centres = grid.centres()
    street = ground.covers(centres).reshape(grid.shape)
    own = ~street & within(street, RING)
    if heading in ground.headings:
        others = [ground.nearest(centres, other) for other in ground.headings if other != heading]
        nearest = np.min(others, axis=0, initial=np.inf)
        own &= (ground.nearest(centres, heading) < nearest + OVERLAP).reshape(grid.shape)
    return Layer(grid, street, own)


def lots_of(plan: Plan, layer: Layer) -> list[Rectangle]:
    """Lots on a layer's own ground."""
    found: list[Rectangle] = []
    for number, rectangle in enumerate(cover(layer.own, round(NARROWEST / CELL))):
        random = seeded(plan.id, "lots", layer.grid.heading, number)
        found += split(rectangle, round(SHORTEST / CELL), round(LONGEST / CELL), random)
    return found


def thickened(gap: Rectangle, street: Mask) -> Rectangle:
    """A lot that fills a gap and reaches behind its neighbours, never into a street: no wall is thin as paper."""
    grown = gap
    for side, outwards in zip(Rectangle._fields, (-1, -1, 1, 1), strict=True):
        for _ in range(round(THICKEN / CELL)):
            wider = grown._replace(**{side: getattr(grown, side) + outwards})
            inside = (
                min(wider.top, wider.left) >= 0 and wider.bottom <= street.shape[0] and wider.right <= street.shape[1]
            )
            if not inside or street[wider.top : wider.bottom, wider.left : wider.right].any():
                break
            grown = wider
    return grown


def near(mask: Mask, units: float) -> Mask:
    """The cells at most `units` from one in `mask`."""
    close: Mask = ndimage.distance_transform_edt(~mask) * CELL <= units
    return close


def boxes(layers: list[Layer]) -> list[Building]:
    """All lots as bare boxes of no height."""
    found = []
    for layer in layers:
        for lot in layer.lots:
            x, z = layer.grid.world((lot.top + lot.bottom) / 2, (lot.left + lot.right) / 2)
            width, length = lot.shape[0] * CELL / 2, lot.shape[1] * CELL / 2
            found.append(Building(round(x, 3), round(z, 3), width, length, layer.grid.heading, 0.0, ""))
    return found


def standing(grid: Grid, buildings: list[Building]) -> Mask:
    """The cells whose middle is in a building."""
    x, z = grid.centres().T
    built = np.zeros(len(x), dtype=bool)
    for building in buildings:
        built |= covers(building, x, z, 1e-6)
    return built.reshape(grid.shape)


def stand_back(plan: Plan, number: int, layer: Layer, layers: list[Layer]) -> list[Rectangle]:
    """The layer's lots that can be seen from the street, some of them set back from it."""
    empty = ~standing(layer.grid, boxes(layers))
    seen = reached(empty, layer.street)
    unseen = empty & ~seen
    own = filled(layer.own.shape, layer.lots)
    kept = [lot for lot in layer.lots if seen[around(lot)].any()]
    seen &= ~own
    return [
        set_back(lot, seen, unseen, seeded(plan.id, "setback", number, place), SETBACKS)
        for place, lot in enumerate(kept)
    ]


def dressed(plan: Plan, seed: str, bare: list[Building]) -> list[Building]:
    """The boxes as buildings, each with another facade than those around it."""
    done: list[Building] = []
    used: dict[str, int] = dict.fromkeys(FACADES, 0)
    for number, box in enumerate(bare):
        random = seeded(seed, plan.id, "building", number)
        facade = another(box, done, used, random)
        used[facade] += 1
        height = round(random.uniform(*random.choice(HEIGHTS)), 2)
        done.append(Building(box.x, box.z, box.half_width, box.half_length, box.heading, height, facade))
    return done


def another(box: Building, done: list[Building], used: dict[str, int], random: Random) -> str:
    """A facade that is rare around here, and on the whole."""
    apart = dict.fromkeys(FACADES, NEAR)
    for other in done:
        distance = round(math.hypot(other.x - box.x, other.z - box.z), 3)
        apart[other.facade] = min(apart[other.facade], distance)
    farthest = max(apart.values())
    return min((f for f in FACADES if apart[f] >= farthest), key=lambda f: (used[f], random.random()))


def bounds_of(plan: Plan) -> tuple[float, float, float, float]:
    """The ground that streets cover: (x from, z from, x to, z to), to a tenth of a unit."""
    grid = Grid.around(surface(plan).corners(), 0.0, CELL)
    centres = grid.centres()
    covered: Points = centres[surface(plan).covers(centres)]
    low, high = np.floor(covered.min(axis=0) * 10) / 10, np.ceil(covered.max(axis=0) * 10) / 10
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])

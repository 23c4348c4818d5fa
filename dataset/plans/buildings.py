"""Generation of the buildings along a plan's streets, facing the street and without gaps to the outside."""

import math
from dataclasses import dataclass, field
from random import Random

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from arramon_client.world import FACADES
from arramon_dataset.layout.grid import CELL, Grid, Mask, Points
from arramon_dataset.layout.lots import CellRectangle, cover_with_rectangles, split_into_lots
from arramon_dataset.layout.masks import RING, connected_to, dilate, rectangle_mask, set_back, with_neighbours
from arramon_dataset.plans.plan import Plan
from arramon_dataset.plans.street_surface import StreetSurface, street_surface
from arramon_dataset.randomness import seeded
from arramon_server.sim.assets.markings import covers
from arramon_server.sim.section import Building

SHORTEST, LONGEST = 3.5, 7.5
"""Range of a lot's side lengths, in units, where the ground is wide enough."""

NARROWEST = 1.5
"""Side length of the smallest square of ground that is built up, in units; deep between the lots, see `DEEP`."""

DEEP = 1.0
"""Ground farther than this from every street is built up completely, in units."""

OVERLAP = 1.5
"""How far lots along one street extend behind the lots along another, in units, to leave no gap between them."""

SETBACKS = (0.0, 0.0, 0.0, 0.25, 0.5)
"""Possible distances of a facade from the edge of the street, in units."""

THICKEN = 1.0
"""How far a lot that fills a gap extends behind its neighbours, in units."""

HEIGHTS = ((1.6, 2.6), (2.6, 4.4), (4.4, 6.5), (6.5, 9.0))
"""Ranges of building heights in units, all equally likely."""

NEAR = 9.0
"""Distance of centres, in units, below which buildings get different facades as long as there are enough."""


@dataclass
class Layer:
    """The ground rasterised along one heading, and the lots along its axes.

    Attributes:
        grid: raster turned to the heading.
        street: cells covered by streets.
        own: cells to build on whose nearest street has this heading.
        lots: building lots on `own` cells.
    """

    grid: Grid
    street: Mask
    own: Mask
    lots: list[CellRectangle] = field(default_factory=list)


def buildings_of_plan(plan: Plan, seed: str) -> tuple[Building, ...]:
    """Return the section's buildings; the same plan and seed give the same result.

    Positions depend on the plan alone; heights and facades also depend on the seed.

    Args:
        plan: street plan.
        seed: seeds heights and facades.
    """
    ground = street_surface(plan)
    layers = [rasterise_layer(ground, heading) for heading in ground.headings]
    for layer in layers:
        layer.lots = lots_of(plan, layer)
    base = rasterise_layer(ground, plan.heading % 90.0)
    gaps = (
        ~base.street
        & dilate(base.street, RING)
        & ~built_cells(base.grid, lot_boxes(layers))
        & ~within_radius(base.street, DEEP)
    )
    base.lots = [thicken(gap, base.street) for gap in cover_with_rectangles(gaps, 1)]
    layers.append(base)
    for number, layer in enumerate(layers):
        layer.lots = apply_setbacks(plan, number, layer, layers)
    return tuple(make_buildings(plan, seed, lot_boxes(layers)))


def rasterise_layer(ground: StreetSurface, heading: float) -> Layer:
    """Return the layer of one heading, without lots. If no street has it, the layer owns all ground to build on."""
    grid = Grid.around(ground.corners(), heading, RING + CELL)
    centres = grid.centres()
    street = ground.covers(centres).reshape(grid.shape)
    own = ~street & dilate(street, RING)
    if heading in ground.headings:
        others = [ground.nearest_distance(centres, other) for other in ground.headings if other != heading]
        nearest = np.min(others, axis=0, initial=np.inf)
        own &= (ground.nearest_distance(centres, heading) < nearest + OVERLAP).reshape(grid.shape)
    return Layer(grid, street, own)


def lots_of(plan: Plan, layer: Layer) -> list[CellRectangle]:
    """Return lots on a layer's own ground."""
    found: list[CellRectangle] = []
    for number, rectangle in enumerate(cover_with_rectangles(layer.own, round(NARROWEST / CELL))):
        random = seeded(plan.id, "lots", layer.grid.heading, number)
        found += split_into_lots(rectangle, round(SHORTEST / CELL), round(LONGEST / CELL), random)
    return found


def thicken(gap: CellRectangle, street: Mask) -> CellRectangle:
    """Return a gap's lot extended behind its neighbours, but not into a street, so that no wall is thin."""
    grown = gap
    for side, outwards in zip(CellRectangle._fields, (-1, -1, 1, 1), strict=True):
        for _ in range(round(THICKEN / CELL)):
            wider = grown._replace(**{side: getattr(grown, side) + outwards})
            inside = (
                min(wider.top, wider.left) >= 0 and wider.bottom <= street.shape[0] and wider.right <= street.shape[1]
            )
            if not inside or street[wider.top : wider.bottom, wider.left : wider.right].any():
                break
            grown = wider
    return grown


def within_radius(mask: Mask, units: float) -> Mask:
    """Return the mask of cells at most `units` from a cell in `mask`."""
    close: Mask = ndimage.distance_transform_edt(~mask) * CELL <= units
    return close


def lot_boxes(layers: list[Layer]) -> list[Building]:
    """Return all lots as buildings of zero height without a facade."""
    found = []
    for layer in layers:
        for lot in layer.lots:
            x, z = layer.grid.world((lot.top + lot.bottom) / 2, (lot.left + lot.right) / 2)
            width, length = lot.shape[0] * CELL / 2, lot.shape[1] * CELL / 2
            found.append(Building(round(x, 3), round(z, 3), width, length, layer.grid.heading, 0.0, ""))
    return found


def built_cells(grid: Grid, buildings: list[Building]) -> Mask:
    """Return the mask of cells whose centres are inside a building."""
    centres = grid.centres()
    tree, built = cKDTree(centres), np.zeros(len(centres), dtype=bool)
    for building in buildings:
        reach = math.hypot(building.half_width, building.half_length) + 1e-3
        near = tree.query_ball_point((building.x, building.z), reach)
        x, z = centres[near].T
        built[near] |= covers(building, x, z, 1e-6)
    return built.reshape(grid.shape)


def apply_setbacks(plan: Plan, number: int, layer: Layer, layers: list[Layer]) -> list[CellRectangle]:
    """Return the layer's lots that are visible from the street, some of them set back from it."""
    empty = ~built_cells(layer.grid, lot_boxes(layers))
    seen = connected_to(empty, layer.street)
    unseen = empty & ~seen
    own = rectangle_mask(layer.own.shape, layer.lots)
    kept = [lot for lot in layer.lots if seen[with_neighbours(lot)].any()]
    seen &= ~own
    return [
        set_back(lot, seen, unseen, seeded(plan.id, "setback", number, place), SETBACKS)
        for place, lot in enumerate(kept)
    ]


def make_buildings(plan: Plan, seed: str, bare: list[Building]) -> list[Building]:
    """Return the boxes as buildings with random heights, and facades that differ from those nearby."""
    done: list[Building] = []
    used: dict[str, int] = dict.fromkeys(FACADES, 0)
    for number, box in enumerate(bare):
        random = seeded(seed, plan.id, "building", number)
        facade = choose_facade(box, done, used, random)
        used[facade] += 1
        height = round(random.uniform(*random.choice(HEIGHTS)), 2)
        done.append(Building(box.x, box.z, box.half_width, box.half_length, box.heading, height, facade))
    return done


def choose_facade(box: Building, done: list[Building], used: dict[str, int], random: Random) -> str:
    """Return the facade whose nearest use is farthest away; ties go to the least used facade."""
    apart = dict.fromkeys(FACADES, NEAR)
    for other in done:
        distance = round(math.hypot(other.x - box.x, other.z - box.z), 3)
        apart[other.facade] = min(apart[other.facade], distance)
    farthest = max(apart.values())
    return min((f for f in FACADES if apart[f] >= farthest), key=lambda f: (used[f], random.random()))


def bounds_of(plan: Plan) -> tuple[float, float, float, float]:
    """Return the bounds of the ground that streets cover, (x from, z from, x to, z to), to a tenth of a unit."""
    grid = Grid.around(street_surface(plan).corners(), 0.0, CELL)
    centres = grid.centres()
    covered: Points = centres[street_surface(plan).covers(centres)]
    low, high = np.floor(covered.min(axis=0) * 10) / 10, np.ceil(covered.max(axis=0) * 10) / 10
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])

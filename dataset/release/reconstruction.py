"""Reconstruction of a section's buildings from its episodes' paths: streets near paths, built up elsewhere."""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from arramon_client.world import FACADES
from arramon_dataset.layout.grid import CELL, Grid, Mask, Points, sample_points
from arramon_dataset.layout.lots import CellRectangle, cover_with_rectangles, split_into_lots
from arramon_dataset.layout.masks import (
    LONGEST,
    RING,
    SHORTEST,
    connected_to,
    dilate,
    rectangle_mask,
    set_back,
    with_neighbours,
)
from arramon_dataset.randomness import seeded
from arramon_server.sim.section import Building, Section

CARVE = 0.75
"""Ground closer than this to a path or a target is free, in units: no corner of a cell beyond it is within 0.57."""

THINNEST = 2.5
"""Built-up ground thinner than this becomes street, in units."""

NARROWEST = 2.0
"""Ground that no square of this side length fits into stays empty, unless it would open to the outside, in units."""

LOWEST, HIGHEST = 2.5, 9.0
"""Range of building heights, in units."""


def reconstruct_section(section_id: str, paths: Sequence[Points], targets: Points) -> Section:
    """Return a section without furniture whose episodes follow these paths; the same input gives the same section.

    No building is closer than 0.5 units to a segment of a path or to a target.

    Args:
        section_id: such as "1"; seeds heights and facades.
        paths: each (n, 2) of (x, z) in units, n at least 1.
        targets: (m, 2) of (x, z), positions of the objects to pick up, m may be 0.

    Raises:
        ValueError: if there is no path.
    """
    if not paths:
        raise ValueError(f"section {section_id}: no paths to reconstruct it from")
    heading = street_heading(paths)
    walked = sample_points([*paths, *(target[None, :] for target in targets)])
    grid = Grid.around(walked, heading, CARVE + RING + CELL)
    street, built = street_and_built_masks(grid, walked)
    buildings = tuple(make_buildings(section_id, grid, lay_out(section_id, built, street)))
    return Section(section_id, heading, bounds_of(walked), buildings, ())


def street_heading(paths: Sequence[Points]) -> float:
    """Return the main direction of the paths, in [0, 180) degrees clockwise from +z.

    Streets cross at right angles, so directions are compared modulo 90 degrees: the result is the weighted mean around
    the histogram's peak, to a tenth of a degree. Of the two perpendicular directions, the one walked more is returned.
    """
    steps = np.concatenate([np.diff(path, axis=0) for path in paths])
    lengths = np.linalg.norm(steps, axis=1)
    if not lengths.sum() > 0.0:
        return 0.0
    directions = np.degrees(np.arctan2(steps[:, 0], steps[:, 1]))
    histogram = np.bincount((directions % 90.0).astype(int) % 90, weights=lengths, minlength=90)
    peak = int(ndimage.uniform_filter1d(histogram, 5, mode="wrap").argmax()) + 0.5
    apart = (directions - peak + 45.0) % 90.0 - 45.0
    near = np.abs(apart) < 5.0
    heading = (peak + float(np.average(apart[near], weights=lengths[near]))) % 90.0
    along = np.abs((directions - heading + 90.0) % 180.0 - 90.0) < 45.0
    if lengths[along].sum() < lengths[~along].sum():
        heading += 90.0
    return round(heading, 1)


def street_and_built_masks(grid: Grid, walked: Points) -> tuple[Mask, Mask]:
    """Return the cells of the street, and those to build on: all within RING of the street. Thin cells are street."""
    distance, _ = cKDTree(walked).query(grid.centres(), distance_upper_bound=2 * CARVE)
    free = (distance <= CARVE).reshape(grid.shape)
    thick = remove_thin(~free, THINNEST)
    return ~thick, thick & dilate(~thick, RING)


def remove_thin(mask: Mask, units: float) -> Mask:
    """Return `mask` without cells that no square of `units` inside it covers. Cells beyond the raster count as set."""
    size = round(units / CELL)
    wide = np.pad(mask, size, constant_values=True)
    kept = ndimage.binary_opening(wide, np.ones((size, size), dtype=bool))
    inside: Mask = kept[size:-size, size:-size]
    return inside


def lay_out(section_id: str, built: Mask, street: Mask) -> list[CellRectangle]:
    """Return the lots with a view of the street, and those that close the gaps between them."""
    rectangles = cover_with_rectangles(built, round(NARROWEST / CELL))
    gaps = built & ~rectangle_mask(built.shape, rectangles) & ~dilate(street, NARROWEST)
    rectangles += cover_with_rectangles(gaps, 1)
    lots = []
    for number, rectangle in enumerate(rectangles):
        random = seeded(section_id, "lots", number)
        lots += split_into_lots(rectangle, round(SHORTEST / CELL), round(LONGEST / CELL), random)
    seen = connected_to(~rectangle_mask(built.shape, lots), street)
    lots = [lot for lot in lots if seen[with_neighbours(lot)].any()]
    unseen = ~rectangle_mask(built.shape, lots) & ~seen
    return [set_back(lot, seen, unseen, seeded(section_id, "setback", number)) for number, lot in enumerate(lots)]


def make_buildings(section_id: str, grid: Grid, lots: Sequence[CellRectangle]) -> list[Building]:
    """Return a building for each lot, with another facade than the one before."""
    buildings: list[Building] = []
    for number, lot in enumerate(lots):
        random = seeded(section_id, "building", number)
        others = [facade for facade in FACADES if not buildings or facade != buildings[-1].facade]
        x, z = grid.world((lot.top + lot.bottom) / 2, (lot.left + lot.right) / 2)
        buildings.append(
            Building(
                x=round(x, 3),
                z=round(z, 3),
                half_width=lot.shape[0] * CELL / 2,
                half_length=lot.shape[1] * CELL / 2,
                heading=grid.heading,
                height=round(random.uniform(LOWEST, HIGHEST), 2),
                facade=random.choice(others),
            )
        )
    return buildings


def bounds_of(walked: Points) -> tuple[float, float, float, float]:
    """Return the bounds of the ground that agents can reach, with a margin: (x from, z from, x to, z to)."""
    low, high = walked.min(axis=0) - CARVE, walked.max(axis=0) + CARVE
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])

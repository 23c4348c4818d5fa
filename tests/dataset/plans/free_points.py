"""Free points of a section: one connected area that the agent's disc can reach."""

import math
from functools import cache

import numpy as np
from scipy import ndimage

from arramon_client.world import AGENT_RADIUS
from arramon_dataset.layout.grid import Mask, Points
from arramon_dataset.layout.solids import Solids, distance_from_rectangle
from arramon_server.sim.section import Section

CELL = 0.1
"""Side of the cells by which connected ground is found, in units."""

MARGIN = 0.1
"""How much more than its radius the disc has around a cell's middle, in units: enough for all of the cell."""


FAR = 1.0
"""Distance from which on a cell counts as infinitely far from everything solid, in units."""


def free_points(section: Section, spacing: float) -> Points:
    """The points of a lattice at which the agent's disc has room, and that it can reach from one another.

    Args:
        section: buildings and street furniture.
        spacing: of the lattice, in units. Points have x and z that are whole multiples of it.

    Returns:
        (n, 2) of (x, z), sorted.
    """
    x0, z0, x1, z1 = section.bounds
    free = largest(clearance(section) > AGENT_RADIUS + MARGIN)
    xs = np.arange(math.ceil(x0 / spacing), math.floor(x1 / spacing) + 1) * spacing
    zs = np.arange(math.ceil(z0 / spacing), math.floor(z1 / spacing) + 1) * spacing
    columns = np.minimum(((xs - x0) / CELL).astype(int), free.shape[0] - 1)
    rows = np.minimum(((zs - z0) / CELL).astype(int), free.shape[1] - 1)
    chosen = np.argwhere(free[np.ix_(columns, rows)])
    return np.stack([xs[chosen[:, 0]], zs[chosen[:, 1]]], axis=1)


@cache
def clearance(section: Section) -> Points:
    """(columns along x, rows along z): how far the middle of each cell of the bounds is from what is solid, in units.

    The first cell's outer corner is the bounds' first corner. Infinite from FAR on: nothing here asks for more.
    """
    x0, z0, x1, z1 = section.bounds
    x = x0 + (np.arange(math.ceil((x1 - x0) / CELL)) + 0.5) * CELL
    z = z0 + (np.arange(math.ceil((z1 - z0) / CELL)) + 0.5) * CELL
    places = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1)
    nearest = np.full((len(x), len(z)), np.inf)
    solids = Solids.of(section)
    for centre, half, heading in zip(solids.centres, solids.halves, solids.headings, strict=True):
        reach = math.hypot(*half) + FAR
        columns, rows = (
            slice(*np.searchsorted(a, (c - reach, c + reach))) for a, c in zip((x, z), centre, strict=True)
        )
        window = nearest[columns, rows]
        np.minimum(window, distance_from_rectangle(places[columns, rows], centre, half, float(heading)), out=window)
    nearest[nearest >= FAR] = np.inf
    return nearest


def largest(free: Mask) -> Mask:
    """The largest connected part of what is free."""
    labels, _ = ndimage.label(free)
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    part: Mask = labels == sizes.argmax()
    return part

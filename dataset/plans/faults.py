"""Validation of sections with random street plans, by properties of the seven sections planned by hand."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from scipy import ndimage

from arramon_client.world import AGENT_RADIUS, FACADES
from arramon_dataset.layout.grid import Points, sample_points
from arramon_dataset.layout.solids import Solids
from arramon_dataset.plans.buildings import bounds_of
from arramon_dataset.plans.graph import StreetGraph
from arramon_dataset.plans.graph_builder import street_graph
from arramon_dataset.plans.plan import Plan
from arramon_dataset.plans.street_furniture import crossings, distances
from arramon_dataset.plans.street_surface import street_surface
from arramon_server.sim.city import label_of_prop
from arramon_server.sim.section import Section

EXTENT = (30.5, 49.5)
"""Range of a section's extent along x and z, in units."""

GROUND = (620, 1080)
"""Range of a section's free ground, in square units."""

JUNCTIONS = 11
"""Minimum number of junctions."""

SPACING, MARGIN, NEAR_FREE = 0.2, 0.1, 0.3
"""Spacing of the sample points of free ground; their clearance beyond the agent's radius; maximum distance between a
street's middle line, except its ends, and free ground. In units."""

SURVEY_MARGIN, MAX_OFF_STREET = 3.0, 1.5
"""Margin around a section's bounds that is sampled, and maximum distance of reachable ground from streets, in units."""

AT_END = 0.75
"""Length at the ends of a street where its middle line need not be free, in units."""

PROPS, BANNERS, LABELS = range(125, 151), range(12, 21), 35
"""Numbers of props and of banners, and minimum number of distinct labels."""

FARTHEST_LANDMARK, AT_CROSSING = 4.95, 3
"""Maximum distance of any point on a street from a landmark, in units, and minimum number of landmarks within that
distance of a crossing."""

TWINS, NEAR_TWINS, NEAR_SHARE = 7.05, 12.0, 0.1
"""Minimum distance of two props that look the same, in units; at most `NEAR_SHARE` of such pairs are closer than
`NEAR_TWINS`."""

ZEBRAS = 4
"""Minimum number of zebra crossings."""


def faults_of_plan(plan: Plan) -> tuple[str, ...]:
    """Return the faults that are visible without building the section: an extent that is too small or too large."""
    x0, z0, x1, z1 = bounds_of(plan)
    if not all(EXTENT[0] < length < EXTENT[1] for length in (x1 - x0, z1 - z0)):
        return (f"it extends over {x1 - x0:.1f} by {z1 - z0:.1f} units",)
    return ()


def faults_of_section(plan: Plan, section: Section) -> tuple[str, ...]:
    """Return descriptions of all other faults of a section; empty if it is as good as the seven made by hand.

    Args:
        plan: street plan of the section.
        section: built from the plan.
    """
    return (*_ground_faults(plan, section), *_landmark_faults(plan, section), *_graph_faults(plan, section))


def _ground_faults(plan: Plan, section: Section) -> Iterator[str]:
    free = _connected(section)
    ground = len(free) * SPACING**2
    if not GROUND[0] < ground < GROUND[1]:
        yield f"it has {ground:.0f} square units of free ground"
    middles = sample_points(plan.lines(), 0.5)
    ends = np.concatenate([line[[0, -1]] for line in plan.lines()])
    inner = middles[distances(middles, ends).min(axis=1) > AT_END]
    streets = street_surface(plan)
    beside = free[~streets.covers(free)]
    if len(beside) and np.min([strip.distance(beside) for strip in streets.strips], axis=0).max() > MAX_OFF_STREET:
        yield "it is open to the outside"
    if not len(free) or max(_nearest(inner, free)) > NEAR_FREE:
        yield "a street is not free, or leads nowhere"


def _connected(section: Section) -> Points:
    """Return the largest connected set of lattice points that the agent can stand on, (n, 2) of (x, z)."""
    x0, z0, x1, z1 = section.bounds
    xs, zs = (np.arange(low - SURVEY_MARGIN, high + SURVEY_MARGIN, SPACING) for low, high in ((x0, x1), (z0, z1)))
    places = np.stack(np.meshgrid(xs, zs, indexing="ij"), axis=-1)
    clear = Solids.of(section).distance(places.reshape(-1, 2)).reshape(places.shape[:2]) > AGENT_RADIUS + MARGIN
    parts, _ = ndimage.label(clear)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    found: Points = places[(parts == sizes.argmax()) & clear]
    return found


def _nearest(places: Points, others: Points) -> list[float]:
    return [float(np.hypot(*(others - place).T).min()) for place in places]


def _landmark_faults(plan: Plan, section: Section) -> Iterator[str]:
    labels = [label_of_prop(prop) for prop in section.props]
    places = np.array([(prop.x, prop.z) for prop in section.props])
    kinds = [label.kind for label in labels]
    if len(labels) not in PROPS or kinds.count("banner") not in BANNERS or len(set(labels)) < LABELS:
        yield f"it has {len(labels)} props, {kinds.count('banner')} banners, {len(set(labels))} labels"
    if kinds.count("zebra_crossing") < ZEBRAS:
        yield f"it has {kinds.count('zebra_crossing')} zebra crossings"
    if distances(sample_points(plan.lines(), 1.0), places).min(axis=1).max() > FARTHEST_LANDMARK:
        yield "a place on a street has no landmark near it"
    if (np.sort(distances(crossings(plan), places), axis=1)[:, AT_CROSSING - 1] > FARTHEST_LANDMARK).any():
        yield "a crossing has too few landmarks"
    twins = np.array([
        np.hypot(*(places[i] - places[j]))
        for i, j in combinations(range(len(labels)), 2)
        if labels[i] == labels[j] and kinds[i] != "zebra_crossing"
    ])  # fmt: skip
    if (twins < TWINS).any() or (twins < NEAR_TWINS).mean() >= NEAR_SHARE:
        yield "props that look the same are too near to each other"
    centres = np.array([(building.x, building.z) for building in section.buildings])
    apart = distances(centres, centres) + 1e9 * np.eye(len(centres))
    facades = [building.facade for building in section.buildings]
    if set(facades) != set(FACADES) or any(facades[i] == facades[int(j)] for i, j in enumerate(apart.argmin(axis=1))):
        yield "a facade is missing, or neighbours share one"


def _graph_faults(plan: Plan, section: Section) -> Iterator[str]:
    graph = street_graph(plan, section)
    kinds = [junction.kind for junction in graph.junctions]
    if len(kinds) < JUNCTIONS or kinds.count("square") != 1 or "t_junction" not in kinds or "bend" not in kinds:
        yield f"its junctions are {', '.join(sorted(kinds))}"
    if {road.kind for road in graph.roads} != {"street", "alley"}:
        yield "it has no alley, or nothing else"
    if not _leads_back(graph):
        yield "a street leaves a junction and does not come back to it"
    middles = np.array([(junction.x, junction.z) for junction in graph.junctions])
    if not street_surface(plan).covers(middles).all():
        yield "a junction lies beside the streets"
    for junction in graph.junctions:
        headings = [arm.heading for arm in junction.arms]
        if graph.junction_at(junction.x, junction.z) != junction or len(set(headings)) < len(headings):
            yield f"{junction.identity} is not clearly apart"
        for arm in junction.arms:
            if arm.road not in [road.identity for road in graph.roads_at(arm.x, arm.z)]:
                yield f"an arm of {junction.identity} does not lie on its road"


def _leads_back(graph: StreetGraph) -> bool:
    named = {junction.identity: junction for junction in graph.junctions}
    return all(
        arm.leads_to in named
        and junction.identity in [back.leads_to for back in named[arm.leads_to].arms]
        and junction.identity in graph.road(arm.road).junctions
        for junction in graph.junctions
        for arm in junction.arms
    )

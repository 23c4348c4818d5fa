"""Placement of street furniture and banners so that every walk soon passes a unique landmark."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from random import Random

import numpy as np

from arramon_client.world import SHOPS
from arramon_dataset.layout.furniture_colours import COLOURS, SHAPE_COLOURS
from arramon_dataset.layout.grid import Points, sample_points, to_street_frame
from arramon_dataset.layout.prop_places import AT_CORNERS, Surroundings, candidate_places, half_size, is_free_of_others
from arramon_dataset.plans.plan import Plan
from arramon_dataset.plans.zebras import zebra_crossings
from arramon_dataset.randomness import seeded
from arramon_server.sim.assets.banners import SHAPES
from arramon_server.sim.labels import SegmentationLabel
from arramon_server.sim.section import Building, Prop

COUNTS = {
    "car": 7, "kiosk": 4, "shop_sign": 6, "awning": 8, "dumpster": 7, "planter": 6, "phone_booth": 5, "bench": 5,
    "tree": 5, "barrier": 6, "banner": 18, "traffic_light": 5, "stop_sign": 4, "speed_sign": 4, "tyre_stack": 4,
    "bags": 4, "mailbox": 5, "bin": 4, "barrel": 7, "hydrant": 5, "lamp_post": 4, "cone": 8,
}  # fmt: skip
"""Maximum number of each kind in a section; bulky kinds are placed first."""

MIN_SEPARATION = 12.0
"""Minimum distance of two props that look the same, where possible, in units."""

SIGHT = 4.0
"""Maximum distance at which a prop is a landmark of a stop, in units."""

STOP = 2.0
"""Distance between stops along the streets, in units."""

CROSSING = 5.5
"""Maximum distance of traffic lights and signs from where two streets meet, in units."""

WEIGHT = 3.0
"""Weight of a stop where streets meet; other stops have weight 1."""

REACH = 5.0
"""Maximum distance of props from the nearest street's middle line, in units."""

TRIED = 80
"""Places evaluated for each prop."""


@dataclass
class Stops:
    """Points along the streets where landmarks are wanted, in the street frame.

    Attributes:
        places: (n, 2).
        weights: (n,).
        seen: (n,) number of landmarks already near each stop.
        crossings: (m, 2) points where streets meet.
        labels: of all props placed, in order.
    """

    places: Points
    weights: Points
    seen: Points
    crossings: Points
    labels: list[SegmentationLabel] = field(default_factory=list)


def furnish_streets(plan: Plan, buildings: Sequence[Building], seed: str) -> tuple[Prop, ...]:
    """Return the section's furniture; the same input gives the same result. All streets' middle lines stay free.

    Args:
        plan: street plan.
        buildings: of the section.
        seed: seeds the placement.
    """
    walked = sample_points(plan.lines())
    surroundings = Surroundings.of(plan.heading, buildings, walked, np.zeros((0, 2)), REACH)
    stops = stops_of(plan)
    random = seeded(seed, plan.id, "landmarks")
    for zebra in zebra_crossings(plan, seeded(seed, plan.id, "zebras")):
        place = to_street_frame(np.array([[zebra.x, zebra.z]]), plan.heading)[0]
        surroundings.add("zebra_crossing", place, zebra.heading - plan.heading, ("", "", ""))
        stops.labels.append(label_of("zebra_crossing", ("", "")))
    for kind, count in COUNTS.items():
        places, fronts = candidate_places(surroundings, kind, random)
        if kind in AT_CORNERS:
            close = distances(places, stops.crossings).min(axis=1, initial=np.inf) <= CROSSING
            places, fronts = places[close], fronts[close]
        for _ in range(count):
            place_landmark(surroundings, stops, kind, places, fronts, random)
    return tuple(surroundings.placed)


def stops_of(plan: Plan) -> Stops:
    """Return the stops of a plan: along all streets, and where they meet."""
    meetings = to_street_frame(crossings(plan), plan.heading)
    places = to_street_frame(sample_points(plan.lines(), STOP), plan.heading)
    at_meeting = distances(places, meetings).min(axis=1, initial=np.inf) < STOP
    return Stops(places, np.where(at_meeting, WEIGHT, 1.0), np.zeros(len(places)), meetings)


def crossings(plan: Plan) -> Points:
    """Return the (x, z) of points where the middle lines of two streets meet or nearly meet, (n, 2)."""
    found = []
    lines = [sample_points([line], 0.25) for line in plan.lines()]
    for one, other in combinations(lines, 2):
        apart = distances(one, other)
        if apart.min() < 0.5:
            found.append(one[apart.min(axis=1).argmin()])
    return np.array(found).reshape(-1, 2)


def place_landmark(
    surroundings: Surroundings, stops: Stops, kind: str, places: Points, fronts: Points, random: Random
) -> None:
    """Place one prop of this kind where a landmark is needed most, if there is a free place."""
    free = np.flatnonzero(is_free_of_others(surroundings, places, max(half_size(kind))))
    if not len(free):
        return
    tried = free[sorted(random.sample(range(len(free)), min(TRIED, len(free))))]
    looks = looks_of(kind)
    if kind == "shop_sign":
        # One shop of each kind in a section, so that its sign alone identifies the location.
        looks = [look for look in looks if label_of(kind, look) not in stops.labels] or looks
    random.shuffle(looks)
    values = landmark_values(surroundings, stops, places[tried], [label_of(kind, look) for look in looks])
    which, where = divmod(int(values.argmax()), len(tried))
    (colour, shape), i = looks[which], int(tried[where])
    shape_colour = random.choice(SHAPE_COLOURS[colour]) if kind == "banner" else ""
    stops.seen += distances(stops.places, places[i][None, :])[:, 0] <= SIGHT
    stops.labels.append(label_of(kind, looks[which]))
    surroundings.add(kind, places[i], float(fronts[i]), (colour, shape, shape_colour))


def looks_of(kind: str) -> list[tuple[str, str]]:
    """Return the (colour, shape) pairs that props of this kind can have."""
    shapes = {"banner": SHAPES, "shop_sign": SHOPS}.get(kind, ("",))
    return [(colour, shape) for colour in sorted(set(COLOURS.get(kind, ("",)))) for shape in shapes]


def label_of(kind: str, look: tuple[str, str]) -> SegmentationLabel:
    """Return the label of a prop."""
    return SegmentationLabel(kind, *look)


def landmark_values(
    surroundings: Surroundings, stops: Stops, places: Points, labels: Sequence[SegmentationLabel]
) -> Points:
    """Return the value of landmarks: higher where there are few, almost 0 near one with the same label.

    Returns:
        (labels, places), for a prop with each label at each place.
    """
    near = distances(places, stops.places) <= SIGHT
    wanted = (near * (stops.weights / (1.0 + stops.seen) ** 2)).sum(axis=1)
    spots = np.array(surroundings.spots).reshape(-1, 3)[:, :2]
    apart = np.full((len(labels), len(places)), 2 * MIN_SEPARATION)
    for number, label in enumerate(labels):
        same = [other == label for other in stops.labels]
        apart[number] = distances(places, spots[same]).min(axis=1, initial=2 * MIN_SEPARATION)
    # Rounded, so that equal values are equal on every machine.
    values: Points = np.round(wanted * np.minimum(apart / MIN_SEPARATION, 1.0) ** 4 + 0.02 * apart, 6)
    return values


def distances(one: Points, other: Points) -> Points:
    """Return the distances between all of (n, 2) and all of (m, 2), (n, m)."""
    apart: Points = np.hypot(one[:, None, 0] - other[None, :, 0], one[:, None, 1] - other[None, :, 1])
    return apart

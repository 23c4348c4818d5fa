"""Puts landmarks into a section: street furniture and banners, so that one never walks far without passing something
that is told apart from all else around.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from random import Random

import numpy as np

from server.episodes.chance import seeded
from server.episodes.furnish import COLOURS, SHAPE_COLOURS
from server.episodes.grid import Points, sample, turn
from server.episodes.plans.plan import Plan
from server.episodes.setting import AT_CORNERS, Setting, candidates, extents, free_of_others
from server.sim.banners import SHAPES
from server.sim.labels import Label
from server.sim.section import Building, Prop

COUNTS = {
    "dumpster": 7, "phone_booth": 5, "bench": 5, "tree": 5, "barrier": 6, "banner": 18, "traffic_light": 5,
    "stop_sign": 4, "speed_sign": 4, "tyre_stack": 4, "bags": 4, "mailbox": 5, "bin": 4, "barrel": 7, "hydrant": 5,
    "lamp_post": 4, "cone": 8,
}  # fmt: skip
"""How many of each kind a section gets where there is room, the bulky ones first."""

APART = 12.0
"""Two things that look the same stand at least this far from each other where that is possible, in units."""

SIGHT = 4.0
"""A thing is a landmark for the stops that are no farther from it, in units."""

STOP = 2.0
"""Between stops along the streets, in units."""

CROSSING = 5.5
"""Traffic lights and signs stand no farther from where two streets meet, in units."""

WEIGHT = 3.0
"""A stop where streets meet counts as so many."""

REACH = 5.0
"""Nothing stands farther than this from the middle line of every street, in units."""

TRIED = 80
"""Places weighed for each thing."""


@dataclass
class Stops:
    """Where along the streets landmarks are wanted, in the setting's frame.

    Attributes:
        places: (n, 2).
        weights: (n,).
        seen: (n,) how many landmarks each has already.
        crossings: (m, 2) where streets meet.
        labels: of everything placed, in order.
    """

    places: Points
    weights: Points
    seen: Points
    crossings: Points
    labels: list[Label] = field(default_factory=list)


def furnish(plan: Plan, buildings: Sequence[Building], seed: str) -> tuple[Prop, ...]:
    """The section's furniture; the same input gives the same. The middle lines of all streets stay free.

    Args:
        plan: where the streets run.
        buildings: of the section.
        seed: draws what stands where.
    """
    trodden = sample(plan.lines())
    setting = Setting.of(plan.heading, buildings, trodden, np.zeros((0, 2)), REACH)
    stops = stops_of(plan)
    random = seeded(seed, plan.id, "landmarks")
    for kind, count in COUNTS.items():
        places, fronts = candidates(setting, kind, random)
        if kind in AT_CORNERS:
            close = distances(places, stops.crossings).min(axis=1, initial=np.inf) <= CROSSING
            places, fronts = places[close], fronts[close]
        for _ in range(count):
            place(setting, stops, kind, places, fronts, random)
    return tuple(setting.placed)


def stops_of(plan: Plan) -> Stops:
    """The stops of a plan: along all streets, and where they meet."""
    meetings = turn(crossings(plan), plan.heading)
    places = turn(sample(plan.lines(), STOP), plan.heading)
    at_meeting = distances(places, meetings).min(axis=1, initial=np.inf) < STOP
    return Stops(places, np.where(at_meeting, WEIGHT, 1.0), np.zeros(len(places)), meetings)


def crossings(plan: Plan) -> Points:
    """(n, 2): the (x, z) where the middle lines of two streets meet, or nearly."""
    found = []
    lines = [sample([line], 0.25) for line in plan.lines()]
    for one, other in combinations(lines, 2):
        apart = distances(one, other)
        if apart.min() < 0.5:
            found.append(one[apart.min(axis=1).argmin()])
    return np.array(found).reshape(-1, 2)


def place(setting: Setting, stops: Stops, kind: str, places: Points, fronts: Points, random: Random) -> None:
    """Adds one thing of this kind where it is needed most as a landmark, unless there is no room left."""
    room = np.flatnonzero(free_of_others(setting, places, max(extents(kind))))
    if not len(room):
        return
    tried = room[sorted(random.sample(range(len(room)), min(TRIED, len(room))))]
    looks = looks_of(kind)
    random.shuffle(looks)
    worths = worth(setting, stops, places[tried], [label_of(kind, look) for look in looks])
    which, where = divmod(int(worths.argmax()), len(tried))
    (colour, shape), i = looks[which], int(tried[where])
    shape_colour = random.choice(SHAPE_COLOURS[colour]) if kind == "banner" else ""
    stops.seen += distances(stops.places, places[i][None, :])[:, 0] <= SIGHT
    stops.labels.append(label_of(kind, looks[which]))
    setting.add(kind, places[i], float(fronts[i]), (colour, shape, shape_colour))


def looks_of(kind: str) -> list[tuple[str, str]]:
    """The (colour, shape) that a thing of this kind can have."""
    shapes = SHAPES if kind == "banner" else ("",)
    return [(colour, shape) for colour in sorted(set(COLOURS.get(kind, ("",)))) for shape in shapes]


def label_of(kind: str, look: tuple[str, str]) -> Label:
    """What a thing would be seen as."""
    return Label(kind, *look)


def worth(setting: Setting, stops: Stops, places: Points, labels: Sequence[Label]) -> Points:
    """How much a landmark is wanted: more where there are few, hardly where one like it is near.

    Returns:
        (labels, places), of a thing with each label at each place.
    """
    near = distances(places, stops.places) <= SIGHT
    wanted = (near * (stops.weights / (1.0 + stops.seen) ** 2)).sum(axis=1)
    spots = np.array(setting.spots).reshape(-1, 3)[:, :2]
    apart = np.full((len(labels), len(places)), 2 * APART)
    for number, label in enumerate(labels):
        same = [other == label for other in stops.labels]
        apart[number] = distances(places, spots[same]).min(axis=1, initial=2 * APART)
    # Rounded, so that what is equal is equal on every machine.
    worths: Points = np.round(wanted * np.minimum(apart / APART, 1.0) ** 4 + 0.02 * apart, 6)
    return worths


def distances(one: Points, other: Points) -> Points:
    """(n, m): between all of (n, 2) and all of (m, 2)."""
    apart: Points = np.hypot(one[:, None, 0] - other[None, :, 0], one[:, None, 1] - other[None, :, 1])
    return apart

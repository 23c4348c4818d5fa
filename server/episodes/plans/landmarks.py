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
            close = np.array([np.hypot(*(stops.crossings - place).T).min() for place in places]) <= CROSSING
            places, fronts = places[close], fronts[close]
        for _ in range(count):
            place(setting, stops, kind, places, fronts, random)
    return tuple(setting.placed)


def stops_of(plan: Plan) -> Stops:
    """The stops of a plan: along all streets, and where they meet."""
    meetings = turn(crossings(plan), plan.heading)
    places = turn(sample(plan.lines(), STOP), plan.heading)
    weights = [WEIGHT if np.hypot(*(meetings - place).T).min(initial=np.inf) < STOP else 1.0 for place in places]
    return Stops(places, np.array(weights), np.zeros(len(places)), meetings)


def crossings(plan: Plan) -> Points:
    """(n, 2): the (x, z) where the middle lines of two streets meet, or nearly."""
    found = []
    lines = [sample([line], 0.25) for line in plan.lines()]
    for one, other in combinations(lines, 2):
        apart = np.hypot(*(one[:, None] - other[None]).transpose(2, 0, 1))
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
    best = max(
        ((look, int(i)) for look in looks for i in tried),
        key=lambda choice: worth(setting, stops, label_of(kind, choice[0]), places[choice[1]]),
    )
    (colour, shape), i = best
    shape_colour = random.choice(SHAPE_COLOURS[colour]) if kind == "banner" else ""
    stops.seen += np.hypot(*(stops.places - places[i]).T) <= SIGHT
    stops.labels.append(label_of(kind, best[0]))
    setting.add(kind, places[i], float(fronts[i]), (colour, shape, shape_colour))


def looks_of(kind: str) -> list[tuple[str, str]]:
    """The (colour, shape) that a thing of this kind can have."""
    shapes = SHAPES if kind == "banner" else ("",)
    return [(colour, shape) for colour in sorted(set(COLOURS.get(kind, ("",)))) for shape in shapes]


def label_of(kind: str, look: tuple[str, str]) -> Label:
    """What a thing would be seen as."""
    return Label(kind, *look)


def worth(setting: Setting, stops: Stops, label: Label, place: Points) -> float:
    """How much a landmark is wanted at a place: more where there are few, hardly where one like it is near."""
    near = np.hypot(*(stops.places - place).T) <= SIGHT
    wanted = float((stops.weights[near] / (1.0 + stops.seen[near]) ** 2).sum())
    same = [spot[:2] for spot, other in zip(setting.spots, stops.labels, strict=True) if other == label]
    apart = min((float(np.hypot(*(place - spot))) for spot in same), default=2 * APART)
    # Rounded, so that what is equal is equal on every machine.
    return round(wanted * min(apart / APART, 1.0) ** 4 + 0.02 * min(apart, 2 * APART), 6)

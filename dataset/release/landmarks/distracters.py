"""Distracter furniture: props that an episode's texts do not name, so that furniture does not reveal the path.

It consists of the furniture that the texts of the section's other episodes name, at the same places: the same kinds,
beside other paths and targets, as dense as the episode's own furniture around its own path.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial import cKDTree

from arramon_dataset.randomness import seeded
from arramon_dataset.release.landmarks.furniture_grid import FreeSpace, apart_from
from arramon_dataset.release.landmarks.mentions import DRAWN
from arramon_dataset.release.landmarks.own_furniture import front_towards_path
from arramon_dataset.release.landmarks.turn_paths import Numbers
from arramon_server.sim.section import ON_WALLS, Prop

AROUND = 3.0
"""Maximum distance of furniture that counts as near a path, in units."""

NAMED_KIND_GAP = 6.0
"""Minimum distance from an episode's paths of distracter furniture of a kind that its texts name, in units: otherwise
"the first booth" could refer to it."""

BESIDE = 1.1
"""Distance of furniture beside an object in the street, in units."""

MAX_DISTRACTERS = 40
"""Maximum number of distracters in an episode."""


def distracter_furniture(
    episode: str,
    own: Sequence[Prop],
    named: frozenset[str],
    others: Mapping[str, Sequence[Prop]],
    space: FreeSpace,
    standing: Sequence[Prop],
) -> list[Prop]:
    """Return the distracter furniture of an episode.

    Args:
        episode: its id.
        own: its own furniture.
        named: kinds that its texts name.
        others: furniture named by the texts of each other episode of the section.
        space: free ground of the episode.
        standing: the section's furniture as it is in the episode.
    """
    random = seeded(episode, "strays")
    ground, near = space.ground, space.from_path
    around = float((near <= AROUND).mean())
    taken = [(prop.x, prop.z, prop.kind) for prop in (*standing, *own) if prop.kind not in ON_WALLS]
    placed: list[Prop] = []

    def place(prop: Prop, spots: Numbers) -> bool:
        clear = free[prop.kind][spots] & apart_from(ground.places[spots], prop.kind, taken)
        if not clear.any():
            return False
        spot = ground.places[spots[int(clear.argmax())]]
        x, z = round(float(spot[0]), 3), round(float(spot[1]), 3)
        placed.append(Prop(prop.kind, x, z, front_towards_path(spot, ground.heading, space.walked), prop.colour))
        taken.append((x, z, prop.kind))
        return True

    free = {kind: space.free_for(kind) & ((near > NAMED_KIND_GAP) if kind in named else True) for kind in DRAWN}
    pool = [prop for _, props in sorted(others.items()) for prop in props]
    random.shuffle(pool)
    beside = sum(np.hypot(*(space.targets - (prop.x, prop.z)).T).min() <= 2 * BESIDE for prop in own)
    tree = cKDTree(ground.places)
    for spot in space.distracters:
        # Furniture stands beside the other objects as often as beside the targets.
        if random.random() < beside / len(space.targets) and pool:
            close = np.array(sorted(tree.query_ball_point(spot, 2 * BESIDE)), dtype=np.intp)
            order = [int(each) for each in close]
            random.shuffle(order)
            any(place(prop, np.array(order, dtype=np.intp)) for prop in random.sample(pool, min(8, len(pool))) if order)
    at_path = [np.hypot(*(space.walked - (prop.x, prop.z)).T).min() <= AROUND for prop in (*own, *placed)]
    wanted = min(MAX_DISTRACTERS, round(sum(at_path) * (1.0 - around) / max(around, 0.05)) + sum(at_path[len(own) :]))
    for prop in pool:
        if len(placed) >= wanted:
            break
        spot = int(tree.query((prop.x, prop.z))[1])
        if near[spot] > AROUND:
            place(prop, np.array([spot]))
    return placed

"""An episode's own furniture: things that differ between episodes, placed where its texts imply them.

A thing stands where the mentions of both turns overlap; mentions without a common place are of different things.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

import numpy as np

from arramon_dataset.layout.prop_places import PATH_GAP, TARGET_GAP
from arramon_dataset.randomness import seeded
from arramon_dataset.release.landmarks.alignment import align
from arramon_dataset.release.landmarks.furniture_grid import FreeSpace, FurnitureGrid, apart_from
from arramon_dataset.release.landmarks.mentions import DRAWN, METAL_BENCH, Event
from arramon_dataset.release.landmarks.recovery import LandmarkMap, TurnText, mention_likelihood
from arramon_dataset.release.landmarks.turn_paths import Indices, Numbers
from arramon_server.sim.assets import furniture
from arramon_server.sim.assets.furniture import footprint_radius
from arramon_server.sim.geometry import wrap
from arramon_server.sim.own_furniture import MovedProp
from arramon_server.sim.section import ON_WALLS, Prop

EXPLAINED = 0.3
"""Minimum likelihood of the mentions that a thing at a place explains, relative to their best place."""

UNLIKELY = 0.02
"""Likelihood of a mention at a place where its kernel does not reach, relative to its best place."""

TRIED = 80
"""Number of likeliest places among which visibility from the mentions decides."""


@dataclass(frozen=True, eq=False)
class FurnitureMention:
    """A mention of a thing that an episode must add.

    Attributes:
        event: the mention.
        turn: of its text.
        likely: (g,) at each place of the ground, relative to the best one.
        eye: (2,) of (x, z), the walker's position at the mention.
    """

    event: Event
    turn: int
    likely: Numbers
    eye: Numbers


def furniture_mentions(texts: Sequence[TurnText], known: LandmarkMap, ground: FurnitureGrid) -> list[FurnitureMention]:
    """Return the mentions in an episode's texts of things that differ between episodes."""
    found = []
    for each in texts:
        if not each.events:
            continue
        aligned = align(each.events, each.path, known.fit)
        for event, posterior, place in zip(each.events, aligned.posterior, aligned.best, strict=True):
            if event.kind in DRAWN and event.recovered_kind != METAL_BENCH:
                likely = mention_likelihood(event, each.path, posterior, ground.places)
                top = float(likely.max())
                if top > 0.0:
                    found.append(FurnitureMention(event, each.turn, likely / top, each.path.places[place]))
    return found


def own_furniture(
    episode: str, mentions: Sequence[FurnitureMention], space: FreeSpace, standing: Sequence[Prop]
) -> list[Prop]:
    """Return the things that an episode's own texts name, clear of its paths and of other furniture.

    Args:
        episode: its id.
        mentions: in its texts.
        space: free ground of the episode.
        standing: furniture that exists already.
    """
    random = seeded(episode, "own furniture")
    taken = [(prop.x, prop.z, prop.kind) for prop in standing if prop.kind not in ON_WALLS]
    placed: list[Prop] = []
    for kind in DRAWN:
        left = [each for each in mentions if each.event.kind == kind]
        indices, news = np.flatnonzero(space.free_for(kind)) if left else np.zeros(0, dtype=np.intp), taken
        while left:
            group = _same_colour(left)
            indices, news = indices[apart_from(space.ground.places[indices], kind, news)], []
            if not len(indices):
                break
            at = _best(group, indices, space.ground)
            explained = [each for each in group if each.likely[at] >= EXPLAINED] or group[:1]
            prop = make_prop(kind, space.ground.places[at], explained, space, random)
            placed.append(prop)
            news.append((prop.x, prop.z, kind))
            taken.append(news[0])
            left = [each for each in left if not any(each is other for other in explained)]
    return placed


def _same_colour(left: Sequence[FurnitureMention]) -> list[FurnitureMention]:
    """Return the mentions that may be of the first one's thing: with its colour or none, and one identity per text."""
    first = left[0]
    colour = next((each.event.colour for each in left if each.event.identity == first.event.identity), "")
    colour = first.event.colour or colour
    names = {first.turn: first.event.identity}
    group = []
    for each in left:
        if each.event.colour not in ("", colour) and colour:
            continue
        colour = colour or each.event.colour
        if names.setdefault(each.turn, each.event.identity) == each.event.identity:
            group.append(each)
    return group


def _best(group: Sequence[FurnitureMention], indices: Indices, ground: FurnitureGrid) -> int:
    """Return the index of the place where a thing best explains the mentions and is visible from them."""
    scores = np.sum([np.log(UNLIKELY + each.likely[indices]) for each in group], axis=0)
    tops = indices[np.argsort(-scores, kind="stable")[:TRIED]]
    best = np.sort(-scores, kind="stable")[:TRIED]
    seen = np.sum([ground.sees(each.eye, ground.places[tops]) for each in group], axis=0)
    return int(tops[int((-best + 2.0 * seen).argmax())])


def make_prop(
    kind: str, place: Numbers, mentions: Sequence[FurnitureMention], space: FreeSpace, random: Random
) -> Prop:
    """Return a prop of a kind at a place, in the stated colour, with its front to the nearest path."""
    possible = (*furniture.COLOURS.get(kind, ()), *furniture.IMPORTED_COLOURS.get(kind, ()))
    said = next((each.event.colour for each in mentions if each.event.colour in possible), "")
    drawn = random.choice(furniture.COLOURS.get(kind, ("",)))
    return Prop(kind, *_rounded(place), front_towards_path(place, space.ground.heading, space.walked), said or drawn)


def front_towards_path(place: Numbers, heading: float, walked: Numbers) -> float:
    """Return the heading along one of the streets' axes that is nearest to the direction of the nearest path."""
    x, z = walked[int(((walked - place) ** 2).sum(axis=1).argmin())] - place
    turns = round((float(np.degrees(np.arctan2(x, z))) - heading) / 90.0)
    return round(wrap(heading + 90.0 * turns), 3)


def move_off_paths(props: Sequence[Prop], space: FreeSpace) -> tuple[list[MovedProp], list[int]]:
    """Return which of a section's props an episode moves off its own paths and objects, and which it leaves out.

    A prop is moved to the nearest free place, and left out if there is none.
    """
    moved, left_out = [], []
    standing = [(prop.x, prop.z, prop.kind) for prop in props if prop.kind not in ON_WALLS]
    for index, prop in enumerate(props):
        radius = footprint_radius(prop.kind)
        if prop.kind in ON_WALLS or not radius:
            continue
        place = np.array([prop.x, prop.z])
        near_path = np.hypot(*(space.walked - place).T).min() < PATH_GAP + radius
        if not near_path and np.hypot(*(space.objects - place).T).min() >= TARGET_GAP + radius:
            continue
        others = [each for each in standing if each[:2] != (prop.x, prop.z)]
        free = np.flatnonzero(space.free_for(prop.kind))
        free = free[apart_from(space.ground.places[free], prop.kind, others)]
        if not len(free):
            left_out.append(index)
            continue
        to = space.ground.places[free[int(np.hypot(*(space.ground.places[free] - place).T).argmin())]]
        moved.append(MovedProp(index, *_rounded(to), prop.heading))
        standing = [*others, (float(to[0]), float(to[1]), prop.kind)]
    return moved, left_out


def _rounded(place: Numbers) -> tuple[float, float]:
    return round(float(place[0]), 3), round(float(place[1]), 3)

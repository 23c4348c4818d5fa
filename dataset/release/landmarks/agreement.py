"""Agreement of a text with a section: whether each named thing stands where the aligned text implies it."""

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
from scipy import ndimage

from arramon_dataset.release.landmarks.alignment import EventAlignment
from arramon_dataset.release.landmarks.kernels import (
    ASIDE,
    BACK,
    STEP,
    is_ahead,
    kernel,
    kernel_frames,
    offsets_in_frames,
)
from arramon_dataset.release.landmarks.mentions import FURNITURE, Event
from arramon_dataset.release.landmarks.turn_paths import Numbers, TurnPath
from arramon_lang.street_words import is_of_colour
from arramon_server.sim.city import label_of_prop
from arramon_server.sim.section import Prop

WITHIN = 4.0
"""Maximum distance of a thing from where the text implies it, in units."""

LIKELY = 0.5
"""Minimum kernel value of the places that a text implies; for things seen ahead, relative to the best place at the same
distance, as farther things are mentioned less often but no less truly."""

PlacedThing = tuple[str, float, float, str, str]
"""A thing in the world: kind, x, z, colour, look."""


@cache
def _apart(manner: str, relation: str) -> Numbers:
    """Return the distance of each entry of a kernel from the places that it implies, in units."""
    table = kernel(manner, relation, "")
    best = table.max(axis=1, keepdims=True) if is_ahead(manner) else 1.0
    distances: Numbers = ndimage.distance_transform_edt((table < LIKELY * best) | (table == 0.0), sampling=STEP)
    return distances


def nearest_match(event: Event, place: int, path: TurnPath, things: Sequence[PlacedThing]) -> tuple[int, float]:
    """Return the index of the matching thing nearest to where a mention implies it, and its distance, or (-1, inf).

    A thing matches if its kind, colour and side are as stated, and for a banner its shape.
    """
    fitting = [number for number, thing in enumerate(things) if _fits(event, thing)]
    if not fitting:
        return -1, np.inf
    origins, directions = kernel_frames(event, path)
    places = np.array([things[number][1:3] for number in fitting], dtype=np.float64)
    ahead, right = offsets_in_frames(origins[place : place + 1], directions[place : place + 1], places)
    table = _apart(event.manner, event.relation)
    row, column = np.rint((ahead[0] + BACK) / STEP).astype(int), np.rint((right[0] + ASIDE) / STEP).astype(int)
    inside = (row >= 0) & (row < table.shape[0]) & (column >= 0) & (column < table.shape[1])
    apart = np.where(inside, table[np.where(inside, row, 0), np.where(inside, column, 0)], np.inf)
    if event.side:
        apart = np.where((right[0] > 0.0) == (event.side == "right"), apart, np.inf)
    best = int(apart.argmin())
    return fitting[best], float(apart[best])


def _fits(event: Event, thing: PlacedThing) -> bool:
    kind, _, _, colour, look = thing
    if kind != event.kind or (kind == "banner" and event.look not in ("", look)):
        return False
    return is_of_colour(event.colour, kind, colour)


def mentions_of(
    events: Sequence[Event],
    aligned: EventAlignment,
    path: TurnPath,
    things: Sequence[PlacedThing],
    kinds: Sequence[str] = FURNITURE,
) -> list[tuple[Event, int, int]]:
    """Return each mention of furniture with its place on the path and the index of its thing; -1 for none."""
    found = []
    for event, place in zip(events, aligned.best, strict=True):
        if event.kind in kinds:
            number, apart = nearest_match(event, place, path, things)
            found.append((event, place, number if apart <= WITHIN else -1))
    return found


def placed_things(props: Sequence[Prop]) -> list[PlacedThing]:
    """Return props as things in a world."""
    labels = [label_of_prop(prop) for prop in props]
    return [(prop.kind, prop.x, prop.z, label.colour, label.look) for prop, label in zip(props, labels, strict=True)]


def landmarks_by_kind(
    things: Sequence[PlacedThing], strength: float
) -> Mapping[str, list[tuple[float, float, float, str]]]:
    """Return (x, z, strength, colour) of each thing by kind, the input of `recovery.LandmarkMap.of`."""
    listed: dict[str, list[tuple[float, float, float, str]]] = {}
    for kind, x, z, colour, _ in things:
        listed.setdefault(kind, []).append((x, z, strength, colour))
    return listed

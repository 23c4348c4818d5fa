"""What stands where, in words: from depth and segmentation, or from one of them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from random import Random
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage

import arramon_lang as lang
from arramon_agents.vlm.prompt_texts import Prompts
from arramon_client.agent import Label, Observation
from arramon_client.world import COLLECTIBLES, FIELD_OF_VIEW, FURNITURE
from arramon_lang.meaning import Thing
from arramon_lang.writing.phrasing import Phraser

MOST_THINGS = 16
"""The nearest things that are named."""

SMALLEST = 0.0004
"""The smallest part of the image that a named thing covers: 20 pixels of 224 x 224."""

STRAIGHT = 4.0
"""Degrees to either side that count as straight ahead."""

SIDE = 20.0
"""Direction of the free distances to the sides, in degrees."""

PLACES = ("building", "wall", "start_tile")
"""Kinds that are neither collectibles nor furniture, and have words in the prompts."""

DEPTH_JUMP = 1.0
"""Difference in depth between neighbouring pixels at which two things of one look are told apart, in units."""

CANNOT_SEE = 60.0
"""Distance from which a free direction is only said to be farther, in units."""


@dataclass(frozen=True)
class SeenThing:
    """A thing in view.

    Attributes:
        label: what is visible of it.
        bearing: direction of its middle in degrees, positive to the right.
        distance: distance along the viewing direction of its nearest tenth, in units; None without depth.
    """

    label: Label
    bearing: float
    distance: float | None


def describe(observation: Observation, labels: Sequence[Label], prompts: Prompts) -> str:
    """Return what is in view as lines of text, in the prompts' language."""
    lines = []
    if observation.depth is not None:
        left, ahead, right = (_free(observation.depth, angle, prompts) for angle in (-SIDE, 0.0, SIDE))
        lines.append(prompts.text("scene.free", left=left, ahead=ahead, right=right))
    if observation.segmentation is not None:
        things = find_things(observation.segmentation, observation.depth, labels)
        lines.append(prompts.text("scene.heading" if things else "scene.nothing"))
        lines += [_line(thing, prompts) for thing in things]
    return "\n".join(lines) or prompts.text("scene.blind")


def find_things(
    segmentation: npt.NDArray[np.uint16], depth: npt.NDArray[np.float32] | None, labels: Sequence[Label]
) -> list[SeenThing]:
    """Return the things in view, nearest first, at most MOST_THINGS.

    Args:
        segmentation: (size, size), each pixel's index in `labels`.
        depth: (size, size) in units, to measure distances and to tell apart things that look alike; or None.
        labels: meaning of the segmentation's values.
    """
    found = []
    for index in np.unique(segmentation):
        label = labels[index]
        if label.kind not in COLLECTIBLES + FURNITURE + PLACES:
            continue
        for pixels in _parts(segmentation == index, depth):
            rows, columns = pixels
            if len(rows) < SMALLEST * segmentation.size:
                continue
            bearing = _bearing(float((columns.min() + columns.max() + 1) / 2), segmentation.shape[1])
            distance = float(np.percentile(depth[rows, columns], 10)) if depth is not None else None
            found.append(SeenThing(label, bearing, distance))
    found.sort(key=lambda thing: (thing.distance or 0.0, abs(thing.bearing)))
    return found[:MOST_THINGS]


def name_of(label: Label, prompts: Prompts) -> str:
    """Return the common words for a thing, such as "the striped red mug", in the prompts' language."""
    if label.kind == "start_tile":
        return prompts.text("scene.start_tile")
    return _phrase(label, prompts.language) or (
        prompts.text(f"scene.{label.kind}") if label.kind in PLACES else _identifier(label)
    )


class _Commonest(Random):
    """A source of choices that always takes the heaviest option, so that things have their common names."""

    def choices(self, population: Any, weights: Any = None, **_: Any) -> list[Any]:
        """Return the option with the largest weight, the first of equals."""
        options, weights = list(population), list(weights if weights is not None else [1.0] * len(population))
        return [options[weights.index(max(weights))]]

    def random(self) -> float:
        """Return the largest draw, so that nothing is left out at random."""
        return 1.0 - 2**-53


@cache
def _phrase(label: Label, language: str) -> str:
    """Return a noun phrase; empty if the language has no words for the thing."""
    try:
        phraser = Phraser(lang.load(language).grammar, _Commonest(0))
        thing = Thing(label.kind, label.colour, label.look)
        return " ".join(phraser.thing(thing, phraser.noun(thing), (), top=False)({}).split())
    except (ValueError, LookupError):
        return ""


def _identifier(label: Label) -> str:
    return " ".join(part for part in (label.look, label.colour, label.kind.replace("_", " ")) if part)


def _parts(mask: npt.NDArray[np.bool_], depth: npt.NDArray[np.float32] | None) -> Iterator[tuple[Any, Any]]:
    """Yield the rows and columns of each connected part of a mask, cut where the depth jumps."""
    if depth is not None:
        jumps = np.zeros_like(mask)
        jumps[:, 1:] |= np.abs(np.diff(depth, axis=1)) > DEPTH_JUMP
        jumps[1:, :] |= np.abs(np.diff(depth, axis=0)) > DEPTH_JUMP
        inner = mask & ~jumps
        mask = inner if inner.any() else mask
    parts, count = ndimage.label(mask)
    for number in range(1, count + 1):
        rows, columns = np.nonzero(parts == number)
        yield rows, columns


def _bearing(column: float, width: int) -> float:
    """Return the direction of an image column in degrees, positive to the right."""
    half = width / 2
    return float(np.degrees(np.arctan((column - half) / half * np.tan(np.radians(FIELD_OF_VIEW / 2)))))


def _free(depth: npt.NDArray[np.float32], angle: float, prompts: Prompts) -> str:
    """Return the distance to the nearest surface at eye height in a direction, as text."""
    size = depth.shape[0]
    column = (np.tan(np.radians(angle)) / np.tan(np.radians(FIELD_OF_VIEW / 2)) + 1) * size / 2
    half = max(1, size // 32)
    low = int(np.clip(column - half, 0, size - 2 * half))
    middle = depth[size // 2 - half : size // 2 + half, low : low + 2 * half]
    hits = middle[middle > 0]
    nearest = float(hits.min()) / np.cos(np.radians(angle)) if hits.size else CANNOT_SEE
    return prompts.text("scene.sky") if nearest >= CANNOT_SEE else f"{nearest:.1f}"


def _line(thing: SeenThing, prompts: Prompts) -> str:
    angle = round(abs(thing.bearing))
    side = (
        prompts.text("scene.ahead")
        if abs(thing.bearing) <= STRAIGHT
        else prompts.text("scene.left" if thing.bearing < 0 else "scene.right", angle=angle)
    )
    name = name_of(thing.label, prompts)
    if thing.distance is None:
        return prompts.text("scene.thing_without_distance", name=name, side=side)
    return prompts.text("scene.thing", name=name, distance=f"{thing.distance:.1f}", side=side)

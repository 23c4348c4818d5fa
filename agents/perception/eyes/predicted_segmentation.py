"""Output of the visual encoder as a predicted segmentation and detected things, for agents that keep a map."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_agents.perception.eyes.detected_things import DetectedThing, NamedParts
from arramon_agents.perception.eyes.encoder import BATCH, Eyes
from arramon_agents.perception.eyes.kernels import label_surfaces
from arramon_agents.perception.eyes.pixel_rays import rays
from arramon_agents.perception.eyes.vocabulary import COLOURED, COLOURS, KINDS, LOOK_GROUPS, SURFACES, look_slices
from arramon_client.agent import Label
from arramon_client.world import COLLECTIBLES, EYE_HEIGHT, FURNITURE

FLAT = (*(kind for kind in SURFACES if kind not in ("building", "wall")), "zebra_crossing")
"""Kinds taken from block predictions; buildings (with facade) and walls (with look) are too."""

_SLICES = look_slices()
_FACADES, _WALLS = (next(group.looks for group in LOOK_GROUPS if group.name == name) for name in ("facade", "wall"))

LABELS: tuple[Label, ...] = (
    *(Label(kind) for kind in FLAT),
    *(Label("building", look=look) for look in (*_FACADES, "")),
    *(Label("wall", look=look) for look in _WALLS),
    *(Label(kind) for kind in (*FURNITURE, *COLLECTIBLES)),
)
"""Labels of the predicted segmentation, by index. Furniture and collectibles have a kind only."""

_FIRST_FACADE = len(FLAT)
_UNCLEAR = _FIRST_FACADE + len(_FACADES)
_FIRST_WALL = _UNCLEAR + 1
_FIRST_THING = _FIRST_WALL + len(_WALLS)
_KIND = {kind: number for number, kind in enumerate(KINDS)}
_CROSSING, _ROAD, _PAVEMENT = (FLAT.index(kind) for kind in ("zebra_crossing", "road", "pavement"))
_FLAT_KINDS = [_KIND[kind] for kind in FLAT]
_IS_BUILDING = np.array([label.kind == "building" for label in LABELS])


MIN_UPRIGHT_HEIGHT = 0.03
"""Height above the ground above which a pixel cannot show the road, in units."""

MIN_STRIPE_BRIGHTNESS = 214
"""Minimum of red, green and blue, of 255, of a zebra crossing's stripes; nothing else on the ground is as bright. In a
block with part of a far crossing, the other pixels are road."""

EYE_LEVEL_BLOCKS = slice(9, 17)
"""Rows of blocks at eye height."""

SAME_WALL_DEPTH = 0.04
"""Maximum difference in depth of two pixels of a wall in one column, as a share of the depth: walls are upright."""

MIN_FACADE_PROBABILITY = 0.6
"""Minimum probability of the most likely facade in a column for it to be the label."""


@dataclass(frozen=True, eq=False)
class FramePercept:
    """Perception of one frame.

    Attributes:
        labels: predicted segmentation, (size, size) uint16, indices in LABELS.
        things: detected things on the ground and on walls.
    """

    labels: npt.NDArray[np.uint16]
    things: list[DetectedThing]


def predict_percepts(eyes: Eyes, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> list[FramePercept]:
    """Predict segmentation and detected things of each frame of a batch.

    Args:
        eyes: the visual encoder.
        rgb: (B, size, size, 3) uint8, in the encoder's image size.
        depth: (B, size, size) units, 0 where there is nothing.
    """
    sights = []
    for first in range(0, len(rgb), BATCH):
        some = rgb[first : first + BATCH], depth[first : first + BATCH]
        kinds, _, looks = (part.numpy() for part in eyes.blocks(*some))
        for number, parts in enumerate(eyes.parts(*some)):
            frame = some[0][number], some[1][number]
            sights.append(FramePercept(_labels(kinds[number], looks[number], *frame, parts), parts.things))
    return sights


def _labels(
    kinds: npt.NDArray[np.float32],
    looks: npt.NDArray[np.float32],
    rgb: npt.NDArray[np.uint8],
    depth: npt.NDArray[np.float32],
    parts: NamedParts,
) -> npt.NDArray[np.uint16]:
    """Return the label of each pixel of a frame, from block probabilities and what is cut out.

    Rims of a thing are of its kind, and what is too small to be named is ground, rather than building: an object to
    pick up is no wall in front of itself.
    """
    cut = parts.parts
    label_of_part = np.zeros(len(cut.is_small), np.uint16)
    for number, named in zip(cut.parts, parts.things, strict=True):
        if named.kind >= len(SURFACES):
            label_of_part[number] = _FIRST_THING + named.kind - len(SURFACES)
    of_things = label_of_part[cut.numbers]
    flat = kinds[_FLAT_KINDS].argmax(0)
    is_room = kinds[_KIND["wall"]].sum() > kinds[_KIND["building"]].sum()
    upright = _rooms(looks) if is_room else _houses(kinds, looks, np.where(of_things == 0, depth, np.float32(0.0)))
    labels = np.empty(depth.shape, np.uint16)
    label_surfaces(
        rgb, depth, upright, flat, rays(len(depth)), EYE_HEIGHT, MIN_UPRIGHT_HEIGHT, _CROSSING, _ROAD,
        MIN_STRIPE_BRIGHTNESS, labels,
    )  # fmt: skip
    is_building = _IS_BUILDING[labels]
    rims = cut.rims()
    labels[is_building & (cut.is_small[cut.numbers] | cut.is_small[rims])] = _PAVEMENT
    for named_as, where in ((of_things, True), (label_of_part[rims], is_building)):
        np.copyto(labels, named_as, where=where & (named_as > 0))
    return labels


def _rooms(looks: npt.NDArray[np.float32]) -> npt.NDArray[np.int64]:
    """Return the label of each block's walls, (28, 28)."""
    walls: npt.NDArray[np.int64] = _FIRST_WALL + looks[_SLICES["wall"]].argmax(0)
    return walls


def _houses(
    kinds: npt.NDArray[np.float32],
    looks: npt.NDArray[np.float32],
    depth: npt.NDArray[np.float32],
) -> npt.NDArray[np.int64]:
    """Return the label of each block's buildings, (28, 28): one facade per column, from its blocks at eye height.

    A block counts by the share of its pixels in which the wall at the horizon is in view, and not a thing, the ground
    or a higher building behind. If the facade is uncertain, the label is a building without facade: solid, but never a
    referent of an instruction. Blocks are not labelled one by one, because blocks at the horizon also show the ground
    in front of a far building. `depth` is 0 where there is a thing or nothing.
    """
    blocks = kinds.shape[1]
    wall = np.where(depth > 0.0, depth, np.float32(np.nan))
    parted = wall.reshape(blocks, -1, blocks, wall.shape[1] // blocks)
    horizon = wall[len(wall) // 2].reshape(blocks, -1)
    shown = (np.abs(parted[EYE_LEVEL_BLOCKS] - horizon) < SAME_WALL_DEPTH * horizon).mean((1, 3))
    chances = kinds[_KIND["building"]][EYE_LEVEL_BLOCKS] * shown * looks[_SLICES["facade"]][:, EYE_LEVEL_BLOCKS]
    mean = chances.sum(1) / np.maximum(chances.sum((0, 1)), 1e-6)  # (facades, columns)
    houses = np.where(mean.max(0) > MIN_FACADE_PROBABILITY, _FIRST_FACADE + mean.argmax(0), _UNCLEAR)
    return np.repeat(houses[None], kinds.shape[1], 0)


def label_of(
    kinds: npt.NDArray[np.floating], colours: npt.NDArray[np.floating], looks: npt.NDArray[np.floating]
) -> Label:
    """Return the most likely label, given unnormalised scores of kinds, colours and looks."""
    kind = KINDS[int(kinds.argmax())]
    colour = COLOURS[int(colours.argmax())]
    group = next((group for group in LOOK_GROUPS if kind in group.kinds), None)
    look = group.looks[int(looks[_SLICES[group.name]].argmax())] if group else ""
    if kind in COLLECTIBLES or kind == "banner" or kind in COLOURED:
        return Label(kind, colour, look)
    return Label(kind, "", look)

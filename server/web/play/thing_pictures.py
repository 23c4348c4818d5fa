"""Pictures of the things that instructions name, drawn by the server's camera: one small JPEG for each kind."""

import math
from threading import Lock

import numpy as np
import numpy.typing as npt
import simplejpeg

from arramon_client.world import (
    BANNER_COLOURS,
    BANNER_SHAPES,
    COLLECTIBLE_COLOURS,
    COLLECTIBLE_PATTERNS,
    COLLECTIBLES,
    FACADES,
    FURNITURE,
    SHOPS,
    WALLS,
)
from arramon_server.errors import NotFound, quoted
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Point, Pose
from arramon_server.sim.labels import LABELS
from arramon_server.sim.own_furniture import OwnFurniture
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import Collectible, EpisodeLayout, Phase, State
from arramon_server.sim.section import ON_WALLS, Building, Prop, Section
from arramon_server.sim.section_world import EpisodeWorld, SectionWorld

DRAWN_SIZE = 448
"""Side length of the frame from which a picture is cut, in pixels."""

MARGIN = 0.12
"""Ground around a thing, as a share of its extent."""

MOST_PIXELS = 112
"""Side length above which pictures are made smaller: twice that at which the page shows them."""

QUALITY = 85

_DISTANCES = {"tree": 7.0, "lamp_post": 6.0, "traffic_light": 6.0, "kiosk": 6.0, "car": 6.0, "zebra_crossing": 2.0}
_NEAR, _USUAL, _FAR = 1.6, 3.5, 16.0
"""Distances from which collectibles, furniture and buildings are drawn, in units."""

_BOUNDS = (-20.0, -20.0, 20.0, 20.0)
_WALL_HEADINGS = {"brick": 0.0, "wood": 90.0, "striped": 180.0, "spotted": 270.0}


def pictured_things() -> list[str]:
    """Return the names of all pictures, in the order in which they are shown: kinds, "building_..." and "wall_..."."""
    buildings, walls = (f"building_{look}" for look in FACADES), (f"wall_{look}" for look in WALLS)
    return [*COLLECTIBLES, *FURNITURE, *buildings, *walls]


class ThingPictures:
    """Draws pictures of things, each at its first use, and keeps them. Thread-safe.

    Args:
        camera: one of `cameras.CAMERAS`.
    """

    def __init__(self, camera: str) -> None:
        self._camera = camera
        self._lock = Lock()
        self._drawn: dict[str, bytes] = {}

    def jpeg(self, name: str) -> bytes:
        """Return the picture of one of `pictured_things`.

        Raises:
            NotFound: for any other name.
        """
        if name not in pictured_things():
            raise NotFound(f"there is no picture of {quoted(name)}")
        with self._lock:
            if name not in self._drawn:
                self._drawn[name] = _draw(name, self._camera)
            return self._drawn[name]


def _draw(name: str, camera: str) -> bytes:
    kind, _, look = name.partition("_") if name.startswith(("building_", "wall_")) else (name, "", "")
    distance = _NEAR if kind in COLLECTIBLES else _FAR if kind == "building" else _DISTANCES.get(kind, _USUAL)
    state = State(Pose(0.0, -distance, 0.0), ())
    if kind == "wall":
        state = State(state.pose, (), phase=Phase.ASSEMBLY, square=RoomCell(2, 2), room_heading=_WALL_HEADINGS[look])
    world = _street_with(kind, look, camera)
    frame = world.render(state, DRAWN_SIZE, segmentation=True)
    assert frame.segmentation is not None
    numbers = [i for i, label in enumerate(LABELS) if label.kind == kind and look in ("", label.look)]
    cut = _smaller(_cut_out(frame.rgb, np.isin(frame.segmentation, numbers)))
    jpeg: bytes = simplejpeg.encode_jpeg(np.ascontiguousarray(cut), quality=QUALITY, colorspace="RGB")
    return jpeg


def _street_with(kind: str, look: str, camera: str) -> EpisodeWorld:
    """Build a street with nothing but one thing at its centre, and the wall behind it if it hangs on one."""
    buildings, props, street = list[Building](), list[Prop](), list[Collectible]()
    if kind == "building":
        buildings.append(Building(0.0, 4.0, 4.0, 4.0, 0.0, 7.0, look))
    elif kind in COLLECTIBLES:
        i = COLLECTIBLES.index(kind)
        shown = ObjectType(COLLECTIBLE_PATTERNS[i % 2], COLLECTIBLE_COLOURS[-i], kind)
        street.append(Collectible(shown, Point(0.0, 0.1, 0.0)))
    elif kind in FURNITURE:
        props.append(_prop(kind))
        if kind in ON_WALLS:
            buildings.append(Building(0.0, 3.0, 4.0, 3.0, 0.0, 6.0, "concrete"))
    section = Section("picture", 0.0, _BOUNDS, tuple(buildings), tuple(props))
    layout = EpisodeLayout(Pose(0.0, 0.0, 0.0), (tuple(street), tuple(street)), ())
    world = SectionWorld(section, camera=camera).in_episode(OwnFurniture(), layout)
    for _part in world.load(drawn=True):
        pass
    return world


def _prop(kind: str) -> Prop:
    if kind == "banner":
        return Prop(kind, 0.0, 0.0, 180.0, BANNER_COLOURS[1], BANNER_SHAPES[0], BANNER_COLOURS[3])
    heading = 90.0 if kind == "car" else 180.0
    return Prop(kind, 0.0, 0.0, heading, shape=SHOPS[0] if kind == "shop_sign" else "")


def _cut_out(rgb: npt.NDArray[np.uint8], mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint8]:
    """Return the smallest square around a mask, with a margin, as far as the frame has it."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    side = math.ceil((1.0 + 2.0 * MARGIN) * max(rows[-1] - rows[0], columns[-1] - columns[0], 1))
    side = min(side, rgb.shape[0])
    top = min(max(0, (rows[0] + rows[-1] - side) // 2), rgb.shape[0] - side)
    left = min(max(0, (columns[0] + columns[-1] - side) // 2), rgb.shape[1] - side)
    return rgb[top : top + side, left : left + side]


def _smaller(rgb: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return a picture of at most about MOST_PIXELS a side, by means over blocks of pixels."""
    block = max(1, rgb.shape[0] // MOST_PIXELS)
    side = rgb.shape[0] // block
    blocks = rgb[: side * block, : side * block].reshape(side, block, side, block, 3)
    smaller: npt.NDArray[np.uint8] = np.rint(blocks.mean(axis=(1, 3))).astype(np.uint8)
    return smaller

"""What every camera is: a function from a scene's actors and a viewpoint to a frame, whatever draws it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from server.sim.catalogue import ALL_TYPES, ObjectType
from server.sim.geometry import EYE_HEIGHT
from server.sim.scene import Body, Scene

FIELD_OF_VIEW = 60.0
"""Degrees, vertical and horizontal: frames are square."""

NEAR, FAR = 0.05, 120.0
"""Clipping distances, in units."""

CAMERAS = ("raster", "tiny")
"""What draws: `raster.RasterCamera`, compiled and fast, or `bullet.World`, TinyRenderer, the reference."""

NOTHING = "nothing"
"""The label of the sky."""


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """Where the camera is, in the scene frame: level, at the agent's eye height.

    Attributes:
        x, y: units, on the scene's ground plane.
        heading: degrees clockwise seen from above, 0 along the scene's +Y.
        z: height in units.
    """

    x: float
    y: float
    heading: float
    z: float = EYE_HEIGHT


@dataclass(frozen=True, slots=True)
class Actor:
    """A collectible posed for one frame: an episode's own objects are not part of the shared scene.

    Attributes:
        type: what it looks like.
        position: (X, Y, Z) of the centre of its base, in the scene frame.
        heading: degrees clockwise seen from above.
        scale: 1 in the city.
    """

    type: ObjectType
    position: tuple[float, float, float]
    heading: float = 0.0
    scale: float = 1.0


@dataclass(frozen=True, eq=False)
class Frame:
    """What a camera saw.

    Attributes:
        rgb: (size, size, 3) uint8.
        depth: (size, size) uint16, the distance along the viewing direction in thousandths of a unit; 0 where nothing
            was hit, 65535 at 65.535 units and beyond.
        segmentation: (size, size) uint16, the number of each pixel's label in the camera's `labels`; None unless it was
            asked for.
    """

    rgb: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.uint16]
    segmentation: npt.NDArray[np.uint16] | None = None


class Camera(Protocol):
    """Draws one scene. Implementations must agree with each other within the edges of things."""

    @property
    def labels(self) -> tuple[str, ...]:
        """What the numbers of a segmentation mean: `labels_of` the scene."""
        ...

    def render(self, viewpoint: Viewpoint, actors: Sequence[Actor], size: int, *, segmentation: bool = False) -> Frame:
        """The frame of `size` x `size` pixels seen from `viewpoint`, with `actors` in the scene for this frame only."""
        ...


def labels_of(scene: Scene) -> tuple[str, ...]:
    """All labels that a picture of the scene can hold, each once: NOTHING, the bodies', every collectible's."""
    bodies = {label_of(body) for body in scene.bodies}
    types = [str(type_) for type_ in ALL_TYPES]
    return (NOTHING, *sorted(bodies.difference(types, [NOTHING])), *types)


def label_of(body: Body) -> str:
    """A body's label: its own, or for want of one its name up to the first "/"."""
    return body.label or body.name.partition("/")[0]

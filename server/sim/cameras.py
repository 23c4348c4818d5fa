"""The camera interface: a camera renders frames of its scene from a viewpoint, with actors."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from arramon_client.world import DEPTH_UNIT, EYE_HEIGHT
from arramon_server.sim.catalogue import ALL_TYPES, ObjectType
from arramon_server.sim.scene import Body, Scene

NEAR, FAR = 0.05, 120.0
"""Clipping distances, in units."""

CAMERAS = ("raster", "tiny")
"""Names of the cameras: `raster.RasterCamera`, compiled and fast, and `bullet.ReferenceCamera` (TinyRenderer)."""

THOUSANDTH = np.float32(DEPTH_UNIT)
"""Depth in units of a thousandth: a product with it, in float32, is what a client decodes from a message."""

NOTHING = "nothing"
"""The label of the sky."""


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """Pose of a level camera in the scene frame, by default at the agent's eye height.

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
        type: its appearance.
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
    """A rendered frame.

    Attributes:
        rgb: (size, size, 3) uint8.
        depth: (size, size) uint16, the distance along the viewing direction in thousandths of a unit; 0 where there
            is nothing, 65535 at 65.535 units and beyond; or float32, the same times THOUSANDTH, if it was drawn into
            such an array.
        segmentation: (size, size) uint16, the number of each pixel's label in the camera's `labels`; None unless it was
            requested.
    """

    rgb: npt.NDArray[np.uint8]
    depth: npt.NDArray[Any]
    segmentation: npt.NDArray[np.uint16] | None = None


def colourless(size: int) -> Frame:
    """Return a new frame of `size` without colours, to draw depth and segmentation into."""
    return Frame(np.empty(0, np.uint8), np.empty((size, size), np.uint16), np.empty((size, size), np.uint16))


class Camera(Protocol):
    """Renderer of one scene. Images of all implementations must agree except at edges."""

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of a segmentation, by number: `labels_of` the scene."""
        ...

    def render(
        self,
        viewpoint: Viewpoint,
        actors: Sequence[Actor],
        size: int,
        *,
        segmentation: bool = False,
        into: Frame | None = None,
    ) -> Frame:
        """Draw a frame.

        Args:
            viewpoint: pose of the camera.
            actors: objects in the scene for this frame only.
            size: side length of the frame, in pixels.
            segmentation: whether to label each pixel.
            into: a frame of this size, whose contiguous arrays are overwritten and returned; None for new ones. Its
                depth may be float32. A requested segmentation is allocated if it has none. If its colours are an empty
                array, none are drawn.
        """
        ...

    def showing(self, scene: Scene) -> "Camera":
        """Return a camera that draws the bodies of another scene, and shares everything else with this camera.

        Args:
            scene: its meshes, textures and labels must be those of the bodies or spare bodies of this camera's scene.

        Raises:
            KeyError: for one that is not.
        """
        ...


def labels_of(scene: Scene) -> tuple[str, ...]:
    """Return all labels that a frame of the scene, with or without its spare bodies, can contain, each once.

    First NOTHING, then those of the bodies and the spare ones, then every collectible's.
    """
    bodies = {label_of(body) for body in (*scene.bodies, *scene.spare)}
    types = [str(type_) for type_ in ALL_TYPES]
    return (NOTHING, *sorted(bodies.difference(types, [NOTHING])), *types)


def label_of(body: Body) -> str:
    """Return a body's label; without one, its name up to the first "/"."""
    return body.label or body.name.partition("/")[0]

"""A scene loaded for play: with its collision check and its camera."""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from arramon_server.sim.cameras import CAMERAS, Camera
from arramon_server.sim.labels import places_of
from arramon_server.sim.physics import WITH_PYBULLET, Physics, physics_of, reference_camera_of
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.scene import Scene

if TYPE_CHECKING:
    from arramon_server.sim.bullet import ReferenceCamera


class LoadedScene:
    """A scene with its collision check and its camera, each built on first use, by one thread.

    Args:
        build: builds the scene.
        camera: one of `cameras.CAMERAS`; the one that needs pybullet also checks collisions.
        physics: makes the collision check. All kinds give equal answers (`rules.CollisionCheck`).
    """

    def __init__(
        self,
        build: Callable[[], Scene],
        camera: str = CAMERAS[0],
        physics: Callable[[Scene], Physics] = physics_of,
    ) -> None:
        self._build = build
        self._camera = camera
        self._physics = physics

    @cached_property
    def scene(self) -> Scene:
        """The scene itself."""
        return self._build()

    @cached_property
    def physics(self) -> Physics:
        """The collision check of the scene."""
        return self._reference if self._camera == WITH_PYBULLET else self._physics(self.scene)

    @cached_property
    def camera(self) -> Camera:
        """The camera of the scene."""
        return self._reference if self._camera == WITH_PYBULLET else RasterCamera(self.scene)

    @cached_property
    def label_numbers(self) -> npt.NDArray[np.uint16]:
        """(n,): the index in `labels.LABELS` of each of the camera's n labels."""
        return places_of(self.camera.labels)

    @cached_property
    def _reference(self) -> "ReferenceCamera":
        return reference_camera_of(self.scene)

    def close(self) -> None:
        """Free what was built. A later use builds it again."""
        built = vars(self)
        for name in ("physics", "_reference"):
            if name in built:
                built[name].close()
        for name in ("scene", "physics", "camera", "label_numbers", "_reference"):
            built.pop(name, None)

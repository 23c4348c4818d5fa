"""Choice of the collision checks: pybullet if it is installed, otherwise plane geometry, with equal results.

pybullet publishes no builds for many machines: see "Two commands" in README.md. It draws the reference camera, too.
"""

from collections.abc import Container, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Protocol

from arramon_server.sim.cameras import CAMERAS
from arramon_server.sim.footprints import Footprints, Place
from arramon_server.sim.scene import Body, Scene

if TYPE_CHECKING:
    from arramon_server.sim.bullet import ReferenceCamera

WITH_PYBULLET = "tiny"
"""The camera that needs pybullet."""

INSTALL_PYBULLET = "pip install 'arramon-server[pybullet]' compiles it, with a C++ compiler"
"""How to install pybullet where the server comes without it."""


class Physics(Protocol):
    """Collision checks in a scene, with or without some bodies removed and added. Close it after use."""

    def way_is_free(self, start: Place, end: Place, removed: Container[Body] = (), added: Sequence[Body] = ()) -> bool:
        """Return whether the agent's disc can move straight from `start` to `end` without touching a solid body.

        Args:
            start: (X, Y) on the scene's ground plane, units.
            end: the same.
            removed: bodies of the scene to ignore.
            added: bodies in addition to those of the scene, each with a collider.
        """
        ...

    def close(self) -> None:
        """Free all resources. A second call has no effect."""
        ...


def has_pybullet() -> bool:
    """Return whether pybullet is installed."""
    return find_spec("pybullet") is not None


def physics_of(scene: Scene) -> Physics:
    """Return the collision checks of a scene: by pybullet if it is installed, otherwise by plane geometry.

    Raises:
        ValueError: for a collider that is not solid at `footprints.PROBE_HEIGHT`; with pybullet also for two bodies
            with the same name, or a mesh or texture that is not in the scene.
    """
    if not has_pybullet():
        return Footprints(scene)
    # Not at the top: where pybullet is not installed the module cannot be imported.
    from arramon_server.sim.bullet import Obstacles

    return Obstacles(scene)


def reference_camera_of(scene: Scene) -> "ReferenceCamera":
    """Return the reference camera of a scene, which also checks its collisions; it needs pybullet.

    Raises:
        ValueError: as `physics_of`.
        ModuleNotFoundError: if pybullet is not installed.
    """
    from arramon_server.sim.bullet import ReferenceCamera

    return ReferenceCamera(scene)


def problem_of_camera(name: str) -> str:
    """Return why a camera is not available: unknown name, or pybullet is not installed; "" if it is available."""
    if name not in CAMERAS:
        return f"expected one of {', '.join(CAMERAS)}"
    if name == WITH_PYBULLET and not has_pybullet():
        return f"which needs pybullet, and that is not installed: {INSTALL_PYBULLET}. Expected {CAMERAS[0]} without it"
    return ""

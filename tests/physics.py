"""pybullet for tests: it is installed only where it has a build, and tests that need it are skipped elsewhere."""

from typing import TYPE_CHECKING

import pytest

from arramon_server.sim.cameras import CAMERAS
from arramon_server.sim.physics import has_pybullet, problem_of_camera

REASON = "pybullet is not installed: pip install 'arramon-server[pybullet]' compiles it, with a C++ compiler"

if TYPE_CHECKING or has_pybullet():
    from arramon_server.sim.bullet import Obstacles as Obstacles
    from arramon_server.sim.bullet import ReferenceCamera as ReferenceCamera
else:

    class _Skipping:
        """Skips the test that makes one."""

        def __init__(self, *_: object, **__: object) -> None:
            pytest.skip(REASON)

    Obstacles = ReferenceCamera = _Skipping

needs_pybullet = pytest.mark.skipif(not has_pybullet(), reason=REASON)
"""Marks a test that needs pybullet."""

EACH_CAMERA = tuple(pytest.param(name, marks=needs_pybullet if problem_of_camera(name) else ()) for name in CAMERAS)
"""The cameras, as parameters of a test."""

ANY_CAMERA = next(name for name in reversed(CAMERAS) if not problem_of_camera(name))
"""A camera that there is; not the default one, if there is another."""

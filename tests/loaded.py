"""Imports and compiles all that a server needs, so that servers can be forked from this process."""

import server.commands.serve  # noqa: F401 - with all that it imports
from server.sim.raster.camera import compile_kernels

compile_kernels()

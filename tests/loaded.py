"""Loads and compiles all that a server needs before it serves: who has imported this can be forked into servers."""

import server.commands.serve  # noqa: F401 - with all that it imports
from server.sim.raster.camera import compile_kernels

compile_kernels()

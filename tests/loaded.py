"""Imports and compiles all that a server and a client need, so that they can be forked from this process."""

import agents.random_walk  # noqa: F401
import arramon_client.cli  # noqa: F401
import server.commands.serve  # noqa: F401 - with all that it imports
from server.sim.raster.camera import compile_kernels

compile_kernels()

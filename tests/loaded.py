"""Imports and compiles all that a server and a client need, so that they can be forked from this process."""

import gc
from importlib import import_module
from importlib.util import find_spec

gc.disable()  # until everything is imported

# ruff: noqa: E402
import arramon_agents.random_walk  # noqa: F401
import arramon_client.cli
import arramon_client.mcp.serving  # noqa: F401
import arramon_server.cli
import arramon_server.process.logs
from arramon_server.sim.physics import has_pybullet
from arramon_server.sim.raster.camera import compile_kernels

arramon_server.cli.load(())  # the modules of every command
if has_pybullet():
    import arramon_server.sim.bullet
if find_spec("openai"):
    import_module("arramon_agents.vlm.agent")
compile_kernels()
# The forks do not look through what they share with this process, which would copy it, for what could be freed.
gc.collect()
gc.freeze()
gc.enable()

"""Imports and compiles all that a server and a client need, so that they can be forked from this process."""

import gc

gc.disable()  # until everything is imported

# ruff: noqa: E402
import agents.random_walk  # noqa: F401
import arramon_client.cli  # noqa: F401
import server.cli
import server.process.logs
from server.sim.physics import has_pybullet
from server.sim.raster.camera import compile_kernels
from tests import recorded_migrations

server.cli.load(())  # the modules of every command
if has_pybullet():
    import server.sim.bullet
compile_kernels()
recorded_migrations.install()
recorded_migrations.record()
# The forks do not look through what they share with this process, which would copy it, for what could be freed.
gc.collect()
gc.freeze()
gc.enable()

"""Pools of processes that generate and export, forked (see `forked`), in place of new interpreters that import it all.

Real commands with `--jobs 2` (`dataset/generation/test_killed.py`, `commands/test_demonstrations.py`) start new ones.
"""

import multiprocessing
from types import SimpleNamespace

from arramon_dataset import parallel
from tests.forked import CONTEXT


def install() -> None:
    """From now on the pools of this process are forked."""
    stand_in = SimpleNamespace(get_context=lambda _method: CONTEXT, parent_process=multiprocessing.parent_process)
    assert vars(parallel)["multiprocessing"] is multiprocessing
    vars(parallel)["multiprocessing"] = stand_in

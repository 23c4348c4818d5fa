"""Folders that the processes of one test session share: what several of them need is made once."""

import fcntl
import os
from collections.abc import Callable
from pathlib import Path

import pytest


def shared_folder(factory: pytest.TempPathFactory, name: str, fill: Callable[[Path], None]) -> Path:
    """The folder with this name, filled by the first process that asks; the others wait until it is done."""
    base = factory.getbasetemp()
    # With xdist every process has a folder of its own in the session's.
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / f"shared-{name}"
    with folder.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "complete").exists():
            folder.mkdir()  # which fails, with the reason given above, where filling it failed
            fill(folder)
            (folder / "complete").touch()
    return folder

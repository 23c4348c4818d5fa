"""Programs that tests start beside Python's: found, or installed where that can be done, or the test is skipped."""

import os
import shutil
import socket
import subprocess
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "scripts" / "services"


def program(name: str, package: str, *folders: str) -> Path:
    """The path of a program: on PATH, or in one of the folders, which may be patterns; skips where there is none."""
    found = _found(name, folders)
    if found is None and os.geteuid() == 0 and shutil.which("apt-get"):
        said = subprocess.run([SCRIPT, package], capture_output=True, text=True, timeout=280)
        found = _found(name, folders)
        if found is None:
            pytest.skip(f"{name} could not be installed by scripts/services {package}: {said.stderr.strip()}")
    if found is None:
        pytest.skip(f"there is no {name}: as root, scripts/services {package} installs it")
    return found


def _found(name: str, folders: tuple[str, ...]) -> Path | None:
    places = [str(place) for folder in folders for place in sorted(Path("/").glob(folder.lstrip("/")), reverse=True)]
    found = shutil.which(name, path=os.pathsep.join([os.environ.get("PATH", ""), *places]))
    return Path(found).resolve() if found else None


def free_port(host: str = "127.0.0.1") -> int:
    """A port that nobody listens on at the moment."""
    with socket.socket() as probe:
        probe.bind((host, 0))
        return int(probe.getsockname()[1])

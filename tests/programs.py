"""External programs that tests start: found, installed where possible, or the test is skipped."""

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests import ROOT

SCRIPT = ROOT / "scripts" / "services"


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


_UNTIL_PARENT_ENDS = """
exec 3<&0
"$@" < /dev/null 3<&- & program=$!
cat <&3 > /dev/null & input=$!
trap 'kill $input 2> /dev/null' TERM
wait $input
kill -INT $program 2> /dev/null
while kill -0 $program 2> /dev/null; do wait $program; done  # the signal above ends a wait
"""
"""For a shell: runs a program until its own standard input ends, however its parent went, or until it is terminated."""


def start(command: Sequence[str], log: Path, *, user: str | None = None) -> "subprocess.Popen[bytes]":
    """Starts a program that ends, as by an interrupt, with the process that is returned, and with this one."""
    with log.open("ab") as said:
        return subprocess.Popen(
            ["sh", "-c", _UNTIL_PARENT_ENDS, "sh", *command],
            user=user,
            stdin=subprocess.PIPE,
            stdout=said,
            stderr=said,
            cwd=log.parent,
            start_new_session=True,
        )


def stop(process: "subprocess.Popen[bytes]") -> None:
    """Ends a program that `start` started."""
    assert process.stdin is not None
    process.stdin.close()
    process.terminate()  # a process that was forked meanwhile, and goes on, holds the other end of its input
    process.wait(timeout=240)


def _found(name: str, folders: tuple[str, ...]) -> Path | None:
    places = [str(place) for folder in folders for place in sorted(Path("/").glob(folder.lstrip("/")), reverse=True)]
    found = shutil.which(name, path=os.pathsep.join([os.environ.get("PATH", ""), *places]))
    return Path(found).resolve() if found else None

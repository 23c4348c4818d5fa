"""`scripts/setup` where it cannot succeed: one line that says why and what to do, and nothing is downloaded or made."""

import ast
import importlib.util
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests import ROOT

GOOD: dict[str, Any] = {
    "system": "Linux", "machine": "x86_64", "bits": 64, "python": (3, 13), "implementation": "CPython",
    "free_threaded": False, "libc": "glibc", "libc_version": (2, 41), "macos": (), "has_venv": True, "writable": True,
    "folder": "/here", "free": 50_000, "has_torch": False, "temporary": "/tmp", "temporary_free": 50_000,
}  # fmt: skip
MAC = {"system": "Darwin", "machine": "arm64", "libc": "", "libc_version": (), "macos": (15, 1)}

NO_BUILDS = "packages have no builds for it"
TORCH = "PyTorch, which trained agents need"
OTHER = "`scripts/setup host` leaves it out"


@pytest.fixture(scope="module")
def preflight() -> ModuleType:
    spec = importlib.util.spec_from_file_location("preflight", ROOT / "scripts" / "preflight.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("kind", ["agents", "dev", "host"])
@pytest.mark.parametrize("machine", [{}, {"python": (3, 11)}, {"python": (3, 14)}, {"machine": "aarch64"}, MAC])
def test_machines_that_will_do(preflight: ModuleType, machine: dict[str, Any], kind: str) -> None:
    assert preflight.problem(SimpleNamespace(**{**GOOD, **machine}), kind) == ""


@pytest.mark.parametrize(
    ("machine", "kind", "said"),
    [
        ({"python": (3, 10)}, "host", "Python 3.11 to 3.14 is needed, this is 3.10: name another with PYTHON=python3"),
        ({"python": (3, 15)}, "host", "Python 3.11 to 3.14 is needed, this is 3.15: name another with PYTHON=python3"),
        ({"implementation": "PyPy"}, "host", f"the usual CPython is needed, this is PyPy: {NO_BUILDS}"),
        ({"free_threaded": True}, "host", f"the usual CPython is needed, this is its free-threaded build: {NO_BUILDS}"),
        ({"bits": 32}, "host", f"a 64-bit Python is needed, this one has 32 bits: {NO_BUILDS}"),
        ({"machine": "riscv64"}, "host", f"an x86-64 or ARM64 processor is needed, this is riscv64: {NO_BUILDS}"),
        ({"libc": "", "libc_version": ()}, "host", "glibc 2.17 or later is needed, this is another C library, such"),
        ({"libc_version": (2, 12)}, "host", f"glibc 2.17 or later is needed, this is 2.12: {NO_BUILDS}"),
        ({"libc_version": (2, 17)}, "dev", f"{TORCH}, needs glibc 2.28 or later, this is 2.17: {OTHER}"),
        ({"system": "Windows"}, "host", "Windows is not supported: on Windows use WSL 2, a Linux inside it"),
        ({**MAC, "macos": (11, 7)}, "host", f"macOS 12 or later is needed, this is 11.7: {NO_BUILDS}"),
        ({**MAC, "macos": (13, 2)}, "agents", f"{TORCH}, needs macOS 14 or later, this is 13"),
        ({**MAC, "machine": "x86_64"}, "agents", f"{TORCH}, has no build for Intel Macs: {OTHER}"),
        ({"has_venv": False}, "host", "Python's module venv is missing or incomplete: on Debian and Ubuntu "),
        ({"writable": False}, "host", "cannot write to /here: clone the repository into a folder of yours"),
        ({"free": 900}, "host", "1000 MB are needed in /here, 900 MB are free"),
        ({"free": 900}, "agents", "3000 MB are needed in /here, 900 MB are free: `scripts/setup host` leaves"),
        ({"temporary_free": 100}, "host", "300 MB are needed in /tmp, 100 MB are free: name another folder"),
    ],
)  # fmt: skip
def test_machines_that_will_not_do(preflight: ModuleType, machine: dict[str, Any], kind: str, said: str) -> None:
    found = preflight.problem(SimpleNamespace(**{**GOOD, **machine}), kind)
    assert found.startswith(said)
    assert "\n" not in found


@pytest.mark.parametrize(
    "machine", [{**MAC, "machine": "x86_64"}, {**MAC, "macos": (13, 2)}, {"libc_version": (2, 17)}]
)
def test_machines_without_pytorch_can_still_host(preflight: ModuleType, machine: dict[str, Any]) -> None:
    assert preflight.problem(SimpleNamespace(**{**GOOD, **machine}), "host") == ""


def test_the_libraries_of_gpus_need_more_space(preflight: ModuleType) -> None:
    machine = SimpleNamespace(**{**GOOD, "free": 5000})
    assert preflight.problem(machine, "agents") == ""
    assert preflight.problem(machine, "agents", cuda=True).startswith("9000 MB are needed in /here, 5000 MB are free")


def test_an_environment_with_pytorch_needs_less_space(
    preflight: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when it is set up again after an update."""
    machine = SimpleNamespace(**{**GOOD, "free": 2500, "has_torch": True})
    assert preflight.problem(machine, "agents") == preflight.problem(machine, "dev") == ""
    assert preflight.problem(SimpleNamespace(**{**GOOD, "free": 2500}), "agents").startswith("3000 MB are needed")
    machine.free = 900
    for kind in ("agents", "host"):
        assert preflight.problem(machine, kind) == "1000 MB are needed in /here, 900 MB are free"
    monkeypatch.setattr(preflight, "ROOT", str(tmp_path))
    assert not preflight.facts().has_torch
    (tmp_path / ".venv/lib/python3.12/site-packages/torch").mkdir(parents=True)
    assert preflight.facts().has_torch


def test_the_version_of_macos_is_asked_for_anew_where_it_is_that_for_old_programs(
    preflight: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A Python that was built with an old SDK is told 10.16, unless the variable says otherwise."""
    python = tmp_path / "python"
    python.write_text('#!/bin/sh\n[ "$SYSTEM_VERSION_COMPAT" = 0 ] && echo 15.1.1 || echo 10.16\n')
    python.chmod(0o755)
    monkeypatch.setattr(preflight.platform, "mac_ver", lambda: ("10.16", ("", "", ""), "arm64"))
    monkeypatch.setattr(preflight.sys, "executable", str(python))
    assert preflight.facts().macos == (15, 1)


def test_the_bounds_are_those_of_the_package_and_hold_this_python(preflight: ModuleType) -> None:
    low, high = preflight.bounds()
    for path in (ROOT / "pyproject.toml", ROOT / "packages" / "agents" / "pyproject.toml"):
        project = tomllib.loads(path.read_text())["project"]
        assert project["requires-python"] == f">={low[0]}.{low[1]},<{high[0]}.{high[1]}"
    assert low <= sys.version_info[:2] < high


def test_it_can_be_read_by_pythons_that_are_too_old() -> None:
    ast.parse((ROOT / "scripts" / "preflight.py").read_text(), feature_version=(3, 6))


OLD = """#!/bin/sh
echo "$*" >> "{log}"
exec "{python}" -c 'import runpy, sys
sys.version_info = ({version}, 0, "final", 0)
sys.argv = sys.argv[1:]
if sys.argv[:1] and sys.argv[0].endswith(".py"):
    runpy.run_path(sys.argv[0], run_name="__main__")
elif sys.argv[:1] == ["-c"]:
    exec(sys.argv[1])
else:
    sys.exit("nothing but the preflight may be run")' "$@"
"""


def set_up(
    tmp_path: Path, pythons: dict[str, str], *, present: str = "", **variables: str
) -> "tuple[int, str, list[str]]":
    """Runs scripts/setup in a copy, with these interpreters alone; returns its status, its output and their calls.

    `present` is the version of the Python in .venv; empty if there is none.
    """
    clone, programs, log = tmp_path / "clone", tmp_path / "bin", tmp_path / "log"
    programs.mkdir(parents=True)
    packages = [str(path.relative_to(ROOT)) for path in ROOT.glob("packages/*/pyproject.toml")]
    assert len(packages) == 2
    for name in ("scripts/setup", "scripts/preflight.py", "pyproject.toml", "clients/python/pyproject.toml", *packages):
        (clone / name).parent.mkdir(parents=True, exist_ok=True)
        (clone / name).write_bytes((ROOT / name).read_bytes())
    for program in ("bash", "cat", "cksum", "dirname", "uname"):
        (programs / program).symlink_to(
            next(p for p in (Path("/usr/bin") / program, Path("/bin") / program) if p.exists())
        )
    for name, version in pythons.items():
        (programs / name).write_text(OLD.format(log=log, python=sys.executable, version=version))
        (programs / name).chmod(0o755)
    if present:
        (clone / ".venv" / "bin").mkdir(parents=True)
        there = clone / ".venv" / "bin" / "python"
        there.write_text(OLD.format(log=f"{log}-present", python=sys.executable, version=present))
        there.chmod(0o755)
    done = subprocess.run(
        ["bash", "scripts/setup", "host"], cwd=clone, env={"PATH": str(programs), **variables}, capture_output=True,
        text=True, timeout=120, check=False,
    )  # fmt: skip
    assert (clone / ".venv").exists() == bool(present)
    return done.returncode, done.stdout + done.stderr, log.read_text().splitlines() if log.exists() else []


@pytest.mark.parametrize("pythons", [{"python3": "3, 10"}, {"python3": "3, 13"}, {}])
def test_the_python_that_made_the_environment_is_used_again(tmp_path: Path, pythons: dict[str, str]) -> None:
    """And what is installed there is kept."""
    _, said, calls = set_up(tmp_path, pythons, present="3, 12")
    assert said.splitlines()[0] == "setting up .venv (once)"
    assert calls == []
    present = (tmp_path / "log-present").read_text().splitlines()
    assert "scripts/preflight.py host" in present
    assert present[-1] == "-m venv .venv"


def test_another_one_is_used_where_it_does_not_fit_any_more(tmp_path: Path) -> None:
    _, _, calls = set_up(tmp_path, {"python3": "3, 13"}, present="3, 10")
    assert "-m venv --clear .venv" in calls


def test_a_named_python_comes_before_that_of_the_environment(tmp_path: Path) -> None:
    _, _, calls = set_up(tmp_path, {"python3.13": "3, 13"}, present="3, 12", PYTHON="python3.13")
    assert "-m venv --clear .venv" in calls


def test_an_old_python_is_refused_in_one_line_before_anything_is_downloaded(tmp_path: Path) -> None:
    status, said, calls = set_up(tmp_path, {"python3": "3, 9"})
    assert status == 2
    assert said == (
        "scripts/setup: Python 3.11 to 3.14 is needed, this is 3.9: name another with PYTHON=python3.13, if it is "
        "installed\n"
    )
    assert set(calls) == {"scripts/preflight.py host"}


def test_a_python_that_fits_is_found_beside_an_old_one(tmp_path: Path) -> None:
    status, said, calls = set_up(tmp_path, {"python3": "3, 9", "python3.12": "3, 12"})
    # It is the second that goes on to make .venv, which the fake refuses.
    assert status != 0
    assert "is needed" not in said
    assert calls[:2] == ["scripts/preflight.py host", "scripts/preflight.py host"]
    assert "-m venv --clear .venv" in calls


def test_a_missing_python_is_named(tmp_path: Path) -> None:
    assert set_up(tmp_path, {}) == (
        2, "scripts/setup: there is no python3: install Python, or name one with PYTHON\n", [],
    )  # fmt: skip


def test_a_named_python_is_used_alone(tmp_path: Path) -> None:
    named = str(tmp_path / "bin" / "my python")
    status, said, _ = set_up(tmp_path, {"python3": "3, 12", "my python": "3, 10"}, PYTHON=named)
    assert status == 2
    assert said.startswith("scripts/setup: Python 3.11 to 3.14 is needed, this is 3.10: ")


@pytest.mark.skipif(os.geteuid() == 0, reason="root can write anywhere: run the tests as another user")
def test_a_folder_that_cannot_be_written_is_refused(
    preflight: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tmp_path.chmod(0o500)
    monkeypatch.setattr(preflight, "ROOT", str(tmp_path))
    assert not preflight.facts().writable
    tmp_path.chmod(0o700)

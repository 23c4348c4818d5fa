"""Check the requirements of `scripts/setup` before anything is downloaded, and print the first unmet one in one line.

    python3 scripts/preflight.py agents|dev|host [cuda]

The kinds are those of `scripts/setup`; with `cuda`, PyTorch includes the libraries for NVIDIA GPUs. The exit status is
2, with a line on standard error, or 0 without one. This script also runs on Python versions that are too old for the
project, from 3.6 on. `requires-python` in pyproject.toml has the supported versions: those for which numba and PyTorch
have builds.
"""

import glob
import os
import platform
import re
import shutil
import struct
import subprocess
import sys
import sysconfig
import tempfile
from types import SimpleNamespace

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

NEEDED = {"host": 1000, "agents": 3000, "dev": 4000}
"""Free disk space required for setup, in MB, with PyTorch for the CPU."""

TORCH = 2000
"""PyTorch's part of it, in MB: not needed if `.venv` contains PyTorch already."""

CUDA = 6000
"""Additional space for the libraries for NVIDIA GPUs, in MB."""

TEMPORARY = {"host": 300, "agents": 800, "dev": 800}
"""Free space required in the temporary folder, where pip unpacks packages one by one, in MB."""

MACHINES = ("x86_64", "amd64", "aarch64", "arm64")
"""Processors for which all packages have builds."""

GLIBC, GLIBC_TORCH, MACOS, MACOS_TORCH = (2, 17), (2, 28), (12, 0), (14, 0)
"""Lowest versions of glibc and macOS for which the packages have builds, without and with PyTorch."""


def bounds():
    """Return the lowest supported Python version and the lowest that is too new, as (3, minor)."""
    with open(os.path.join(ROOT, "pyproject.toml"), encoding="utf-8") as file:
        low, high = re.search(r'^requires-python = ">=3\.(\d+),<3\.(\d+)"', file.read(), re.MULTILINE).groups()
    return (3, int(low)), (3, int(high))


def facts():
    """Return the relevant properties of this machine."""
    libc, libc_version = platform.libc_ver()
    return SimpleNamespace(
        system=platform.system(),
        machine=platform.machine(),
        bits=8 * struct.calcsize("P"),
        python=sys.version_info[:2],
        implementation=platform.python_implementation(),
        free_threaded=bool(sysconfig.get_config_var("Py_GIL_DISABLED")),
        libc=libc,
        libc_version=_numbers(libc_version),
        macos=_macos(),
        has_torch=bool(glob.glob(os.path.join(glob.escape(ROOT), ".venv", "lib", "python*", "site-packages", "torch"))),
        has_venv=_has("venv") and _has("ensurepip"),
        writable=os.access(ROOT, os.W_OK),
        folder=ROOT,
        free=_free(ROOT),
        temporary=tempfile.gettempdir(),
        temporary_free=_free(tempfile.gettempdir()),
    )


def problem(machine, kind, cuda=False):
    """Return why setup cannot succeed on a machine, and what to do about it; "" if all requirements are met.

    Args:
        machine: as `facts` returns it.
        kind: agents, dev or host.
        cuda: whether PyTorch includes the libraries for NVIDIA GPUs.
    """
    low, high = bounds()
    needed = NEEDED[kind] + (CUDA if cuda else 0)
    if machine.has_torch and kind != "host" and not cuda:
        needed -= TORCH
    smaller = ": `scripts/setup host` leaves PyTorch out, which needs most of it"
    if kind == "host" or machine.has_torch:
        smaller = ""
    usual, other = "packages have no builds for it", "`scripts/setup host` leaves it out"
    mac, torch = machine.system == "Darwin", "PyTorch, which trained agents need,"
    checks = (
        (
            machine.system not in ("Linux", "Darwin"),
            f"{machine.system or 'this system'} is not supported: on Windows use WSL 2, a Linux inside it",
        ),
        (
            not low <= machine.python < high,
            f"Python 3.{low[1]} to 3.{high[1] - 1} is needed, this is {_dotted(machine.python)}: name another with "
            f"PYTHON=python3.{high[1] - 2}, if it is installed",
        ),
        (
            machine.implementation != "CPython" or machine.free_threaded,
            f"the usual CPython is needed, this is {_implementation(machine)}: {usual}",
        ),
        (machine.bits != 64, f"a 64-bit Python is needed, this one has {machine.bits} bits: {usual}"),
        (
            machine.machine.lower() not in MACHINES,
            f"an x86-64 or ARM64 processor is needed, this is {machine.machine}: {usual}",
        ),
        (
            machine.system == "Linux" and (machine.libc != "glibc" or machine.libc_version < GLIBC),
            f"glibc {_dotted(GLIBC)} or later is needed, this is {_libc(machine)}: {usual}",
        ),
        (
            machine.system == "Linux" and kind != "host" and machine.libc_version < GLIBC_TORCH,
            f"{torch} needs glibc {_dotted(GLIBC_TORCH)} or later, this is {_dotted(machine.libc_version)}: {other}",
        ),
        (
            mac and machine.macos < MACOS,
            f"macOS {MACOS[0]} or later is needed, this is {_dotted(machine.macos)}: {usual}",
        ),
        (
            mac and kind != "host" and machine.machine == "x86_64",
            f"{torch} has no build for Intel Macs: {other}",
        ),
        (
            mac and kind != "host" and machine.macos < MACOS_TORCH,
            f"{torch} needs macOS {MACOS_TORCH[0]} or later, this is {_dotted(machine.macos)}: {other}",
        ),
        (
            not machine.has_venv,
            "Python's module venv is missing or incomplete: on Debian and Ubuntu install it with "
            "`apt install python3-venv`, as root",
        ),
        (not machine.writable, f"cannot write to {machine.folder}: clone the repository into a folder of yours"),
        (
            machine.free < needed,
            f"{needed} MB are needed in {machine.folder}, {machine.free} MB are free{smaller}",
        ),
        (
            machine.temporary_free < TEMPORARY[kind],
            f"{TEMPORARY[kind]} MB are needed in {machine.temporary}, {machine.temporary_free} MB are free: name "
            "another folder with TMPDIR",
        ),
    )
    return next((message for is_wrong, message in checks if is_wrong), "")


def _macos():
    """Return the version of macOS; () elsewhere. Pythons built before macOS 11 report 10.16 for all later ones."""
    version = _numbers(platform.mac_ver()[0])
    if version == (10, 16):
        command = [sys.executable, "-sS", "-c", "import platform; print(platform.mac_ver()[0])"]
        output = subprocess.check_output(command, env=dict(os.environ, SYSTEM_VERSION_COMPAT="0"))  # noqa: S603 - this very Python
        version = _numbers(output.decode("ascii"))
    return version


def _implementation(machine):
    return "its free-threaded build" if machine.implementation == "CPython" else machine.implementation


def _libc(machine):
    return _dotted(machine.libc_version) if machine.libc == "glibc" else "another C library, such as Alpine's musl"


def _dotted(version):
    return ".".join(map(str, version))


def _numbers(version):
    return tuple(int(number) for number in re.findall(r"\d+", version)[:2])


def _has(module):
    try:
        __import__(module)
    except ImportError:
        return False
    return True


def _free(folder):
    return shutil.disk_usage(folder).free // 10**6


if __name__ == "__main__":
    message = problem(facts(), sys.argv[1], "cuda" in sys.argv[2:])
    if message:
        sys.stderr.write(f"scripts/setup: {message}\n")
        sys.exit(2)

"""Virtual environments with this project's client and one framework each, downloaded once in a test session."""

import os
import shutil
import subprocess
from importlib.metadata import distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests import ROOT
from tests.shared import shared_folder
from tests.virtual_environments import PIP, Environment

FRAMEWORKS = {"inspect": "inspect-ai", "openenv": "openenv-core", "verifiers": "verifiers"}
"""The framework of each extra."""

LEFT_OUT = {"openenv": {"gradio"}}
"""Requirements that are not downloaded, as only parts that are not used import them: a web page of 130 MB."""


def framework_python(factory: pytest.TempPathFactory, extra: str) -> Path:
    """Return the Python of the environment with an extra's framework; skips where there is no package index.

    Nothing is skipped in continuous integration.
    """
    folder = shared_folder(factory, f"door-{extra}", lambda folder: _fill(folder, extra))
    if (folder / "missing").exists() and not os.environ.get("CI"):
        pytest.skip(f"{FRAMEWORKS[extra]} cannot be downloaded: pip reaches no package index that has it")
    return folder / "environment" / "bin" / "python"


def _fill(folder: Path, extra: str) -> None:
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder)]
    sources = shutil.copytree(ROOT / "clients" / "python", folder / "sources")  # As building leaves files there.
    subprocess.run([*PIP, "wheel", *options, str(sources)], check=True, capture_output=True)
    environment = Environment(folder / "environment", sorted(folder.glob("*.whl")))
    said = environment.download(*_wanted(folder, FRAMEWORKS[extra], LEFT_OUT.get(extra, set())))
    if said.returncode == 0 and extra in LEFT_OUT:
        said = environment.download("--no-deps", FRAMEWORKS[extra])
    if "No matching distribution found" in said.stderr and "from versions: none" in said.stderr:
        (folder / "missing").touch()
    else:
        assert said.returncode == 0, said.stdout + said.stderr


def _wanted(folder: Path, framework: str, left_out: set[str]) -> list[str]:
    """Return the framework, or its requirements but those that are left out, and what its users have besides."""
    if not left_out:
        return [framework, "pillow"]
    there = folder / "framework"
    command = [*PIP, "install", "--quiet", "--no-deps", "--no-compile", "--target", str(there), framework]
    if subprocess.run(command, check=False, capture_output=True).returncode:
        return [framework]  # Where there is no index, the caller finds out.
    found = next(each for each in distributions(path=[str(there)]) if each.metadata["Name"] == framework)
    required = [Requirement(line) for line in found.requires or ()]
    kept = [each for each in required if not each.marker and canonicalize_name(each.name) not in left_out]
    return [*map(str, kept), "pillow", "uv"]

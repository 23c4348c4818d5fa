"""Architecture rules: allowed imports, dependencies, and names in CONTRIBUTING.md."""

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import ROOT

SHARED = {
    "server.errors", "server.private_files", "server.addresses", "server.parallel", "server.image_threads",
    "server.per_split", "server.visible_text", "server.split_times", "server.closing", "arramon.strict_json",
}  # fmt: skip
"""Modules of the server that any of its packages may import; they import nothing but each other, and the lifeline. The
last one is of the contract's package, and imports nothing."""

WORLD = {"server.sim", "server.sim.assets", "server.sim.raster"}

# By package (with its subpackages, unless these have a line of their own): what it may import besides itself.
ALLOWED: dict[str, set[str]] = {
    "server/sim": WORLD,
    "server/scoring": set(),
    "server/episodes": {*SHARED, "server.sim"},
    "server/runs/storage": SHARED,
    "server/runs/play": {*SHARED, *WORLD, "server.runs.storage", "server.episodes", "server.scoring"},
    "server/runs/accounts": {*SHARED, "server.runs.storage"},
    "server/runs/results": {
        *SHARED, *WORLD, "server.runs.storage", "server.runs.play", "server.runs.accounts", "server.episodes",
        "server.scoring", "arramon",
    },
    "server/runs/transfer": {*SHARED, "server.runs.storage"},
    "server/runs": {
        *SHARED, *WORLD, "server.__version__", "server.runs.storage", "server.runs.play", "server.runs.accounts",
        "server.runs.results", "server.episodes",
    },
    "server/board": {*SHARED, "server.runs", "server.episodes", "server.scoring"},
    "server/web": {
        *SHARED, *WORLD, "server.__version__", "server.board", "server.runs", "server.episodes", "server.scoring",
        "server.configuration", "server.process.metrics", "server.process.tls",
    },
    "server/api": {
        *SHARED, *WORLD, "server.__version__", "server.board", "server.runs", "server.episodes", "server.scoring",
        "server.configuration", "arramon",
    },
    "server/configuration": {*SHARED, *WORLD, "server.runs.play.clocks"},
    "server/process": {
        *SHARED, *WORLD, "server.__version__", "server.api", "server.board", "server.web", "server.runs",
        "server.episodes", "server.configuration", "arramon",
    },
    "server/dataset": {
        *SHARED, *WORLD, "server.episodes", "server.scoring", "lang",
        "server.runs.play.session", "server.runs.play.worlds",  # An agent is tried, and pictured, by the very rules.
        "arramon_client",  # The follower, which is an agent, tries every instruction.
    },
    "server/environments": {
        *SHARED, *WORLD, "server.episodes", "server.scoring", "server.runs.play.session", "server.runs.play.worlds",
        "server.dataset", "server.api.messages", "lang", "arramon",
        "arramon_client",  # It is the backend of the client's environments, in the client's own types.
    },
    "server/demonstrations": {
        *SHARED, *WORLD, "server.__version__", "server.episodes", "server.environments", "server.runs.play.session",
        "server.runs.play.worlds", "server.runs.results.reports", "server.runs.storage",
        "arramon_client",  # What is exported are the observations of the client's environments.
    },
    "agents": {"arramon_client", "arramon", "lang"},
    "agents/learning/simulated": {  # For training alone: no agent imports it at play.
        *WORLD, "server.dataset", "server.episodes", "server.errors", "server.scoring", "agents.follower",
        "agents.learning", "agents.vl_map", "arramon_client", "lang",
    },
    "clients/python/arramon_client": {"arramon"},
    "lang": set(),
}  # fmt: skip
OURS = ("server", "agents", "lang", "arramon_client", "arramon", "tests", "examples")


def imports(path: Path) -> Iterator[str]:
    """The full names of everything that a module imports: `package.module` or `package.module.name`."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def sources(folder: str) -> list[Path]:
    """The modules of a package, without those of a subpackage that has a line of its own."""
    others = [ROOT / other for other in ALLOWED if other.startswith(folder + "/")]
    return [
        path
        for path in (ROOT / folder).rglob("*.py")
        if "_pb2" not in path.name and "versions" not in path.parts and not any(o in path.parents for o in others)
    ]


def is_within(name: str, package: str) -> bool:
    return name == package or name.startswith(package + ".")


@pytest.mark.parametrize("folder", ALLOWED)
def test_packages_import_only_allowed_packages(folder: str) -> None:
    own = folder.removeprefix("clients/python/").replace("/", ".")
    found = sources(folder)
    assert found
    for path in found:
        for name in imports(path):
            if name.split(".")[0] in OURS:
                is_allowed = any(is_within(name, package) for package in {own, *ALLOWED[folder]})
                assert is_allowed, f"{path.relative_to(ROOT)} imports {name}"


def test_every_server_package_has_an_import_rule() -> None:
    """Not the command line, which may import everything."""
    packages = {path.parent for path in (ROOT / "server").glob("*/__init__.py")} - {ROOT / "server" / "commands"}
    assert {package.relative_to(ROOT).as_posix() for package in packages} <= ALLOWED.keys()


def test_serve_imports_no_dataset_language_or_agent_code() -> None:
    """Neither when it is started, with all of its pages, nor when it plays."""
    code = (
        "import sys, server.commands.serve, server.process.assembly, server.process.workers, server.web.pages; "
        "print([name for name in sys.modules if name.startswith("
        "('server.dataset', 'server.demonstrations', 'lang', 'agents', 'torch'))])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == "[]"


def test_agents_at_play_import_nothing_of_the_server() -> None:
    """Nor what trains them."""
    code = (
        "import sys, agents.seeing_follower, agents.vl_map.agent, agents.vl_grounded.agent; "
        "import agents.learning.vision.eyes; "
        "print([name for name in sys.modules if name.split('.')[0] == 'server' or 'simulated' in name])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == "[]"


TRACE = re.compile(r"^(\S+\.py): (\S+)", re.MULTILINE)


def test_traces_in_contributing_name_existing_functions() -> None:
    """So that the map stays true."""
    lines = TRACE.findall((ROOT / "CONTRIBUTING.md").read_text())
    assert len(lines) > 25
    for path, name in lines:
        *classes, function = name.split(".")
        nodes: list[ast.stmt] = ast.parse((ROOT / path).read_text()).body
        for wanted in classes:
            (found,) = [node for node in nodes if isinstance(node, ast.ClassDef) and node.name == wanted]
            nodes = found.body
        names = [node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
        assert function in names, f"{path} has no {name}"


def test_paths_in_contributing_exist() -> None:
    for path in re.findall(
        r"`((?:server|clients|agents|lang|proto|tests)/[\w/.-]*)`", (ROOT / "CONTRIBUTING.md").read_text()
    ):
        assert "LANGUAGE" in path or "lang/xx" in path or (ROOT / path).exists(), path


def test_only_one_file_imports_pybullet() -> None:
    everywhere = [path for folder in ("server", "agents", "lang", "clients") for path in (ROOT / folder).rglob("*.py")]
    assert [path.name for path in everywhere if "pybullet" in set(imports(path))] == ["bullet.py"]


def test_only_agents_may_import_torch() -> None:
    for folder in ("server", "clients", "proto", "lang"):
        for path in (ROOT / folder).rglob("*.py"):
            assert not {"torch", "transformers"} & {name.split(".")[0] for name in imports(path)}, path


def test_client_has_only_the_listed_dependencies() -> None:
    project = tomllib.loads((ROOT / "clients" / "python" / "pyproject.toml").read_text())["project"]
    needs = {dependency.split("=")[0].split(">")[0] for dependency in project["dependencies"]}
    assert needs == {"arramon-proto", "cryptography", "grpcio", "numpy", "rich", "simplejpeg", "zstandard"}


def test_required_repository_files_exist() -> None:
    for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE", ".ci/run", "scripts/check"):
        assert (ROOT / name).is_file()


def test_no_file_holds_a_merge_conflict() -> None:
    done = subprocess.run(
        ["git", "grep", "-lE", "^(<<<<<<<|>>>>>>>) "], capture_output=True, text=True, cwd=ROOT, check=False
    )
    if done.returncode > 1:
        pytest.skip("not a git checkout")
    assert not done.stdout.split()

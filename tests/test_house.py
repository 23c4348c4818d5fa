"""The rules of the house that a tool can check: who imports whom, and what the pieces need."""

import ast
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

# Where -> what its modules may import of this repository.
ALLOWED = {
    "server/sim": {"server.sim"},
    "server/scoring": {"server.scoring"},
    "server/episodes": {"server.episodes", "server.sim", "server.errors", "server.private", "lang"},
    "server/runs": {
        "server",
        "server.runs",
        "server.episodes",
        "server.scoring",
        "server.sim",
        "server.errors",
        "server.private",
        "arramon",
    },
    "server/board": {"server.board", "server.runs", "server.episodes", "server.scoring", "server.errors"},
    "server/web": {
        "server",
        "server.web",
        "server.board",
        "server.runs",
        "server.episodes",
        "server.scoring",
        "server.sim",
        "server.errors",
        "server.config",
        "server.metrics",
        "server.tls",
    },
    "agents": {"agents", "arramon_client", "lang", "arramon"},
    "clients/python/arramon_client": {"arramon_client", "arramon"},
    "lang": {"lang"},
}
OURS = ("server", "agents", "lang", "arramon_client", "arramon", "tests", "examples")


def imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def sources(folder: str) -> list[Path]:
    return [
        path for path in (ROOT / folder).rglob("*.py") if "_pb2" not in path.name and "migrations" not in path.parts
    ]


@pytest.mark.parametrize("folder", ALLOWED)
def test_imports_run_one_way(folder: str) -> None:
    found = sources(folder)
    assert found
    for path in found:
        for name in imports(path):
            if name.split(".")[0] in OURS:
                allowed = {".".join(name.split(".")[: n + 1]) for n in range(name.count(".") + 1)} & ALLOWED[folder]
                assert allowed - {"server"} or name == "server", f"{path.relative_to(ROOT)} imports {name}"


def test_one_file_imports_pybullet() -> None:
    everywhere = [path for folder in ("server", "agents", "lang", "clients") for path in sources(folder)]
    assert [path.name for path in everywhere if "pybullet" in set(imports(path))] == ["bullet.py"]


def test_nobody_imports_torch_where_it_is_not_needed() -> None:
    for folder in ("server", "clients", "proto", "lang"):
        for path in sources(folder):
            assert not {"torch", "transformers"} & {name.split(".")[0] for name in imports(path)}, path


def test_the_client_is_light() -> None:
    project = tomllib.loads((ROOT / "clients" / "python" / "pyproject.toml").read_text())["project"]
    needs = {dependency.split("=")[0].split(">")[0] for dependency in project["dependencies"]}
    assert needs == {"arramon-proto", "cryptography", "grpcio", "numpy", "rich", "simplejpeg", "zstandard"}


def test_the_files_that_a_house_has() -> None:
    for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE", ".ci/run", "scripts/check"):
        assert (ROOT / name).is_file()

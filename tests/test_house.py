"""Architecture rules: allowed imports, dependencies, and names in CONTRIBUTING.md."""

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import ROOT, import_cycles, tiny


def server(*names: str) -> set[str]:
    """Return the full names of modules and packages of the server."""
    return {f"arramon_server.{name}" for name in names}


def client(*names: str) -> set[str]:
    """Return the full names of modules and packages of the client."""
    return {f"arramon_client.{name}" for name in names}


SHARED = {
    *server("errors", "private_files", "addresses", "image_threads", "per_split", "visible_text",
            "split_times", "closing_times"),
    "arramon.strict_json",
}  # fmt: skip
"""Modules of the server that any of its packages may import; they import nothing but each other, and the client's
lifeline and number of cores. The last one is of the contract's package, and imports nothing."""

WORLD = server("sim", "sim.assets", "sim.raster")

READING = {*server("errors", "episodes"), "arramon.strict_json"}
"""What reading and writing splits takes."""

WORLD_CONSTANTS = "arramon_client.world"
"""Constants that any package may import; the module imports nothing of ours."""

# By package (with its subpackages, unless these have a line of their own): what it may import besides itself.
ALLOWED: dict[str, set[str]] = {
    "arramon_server.sim": WORLD,
    "arramon_server.scoring": set(),
    "arramon_server.episodes": {*SHARED, *server("sim")},
    "arramon_server.runs.storage": SHARED,
    "arramon_server.runs.play": {*SHARED, *WORLD, *server("runs.storage", "episodes", "scoring")},
    "arramon_server.runs.accounts": {*SHARED, *server("runs.storage")},
    "arramon_server.runs.results": {
        *SHARED, *WORLD, *server("runs.storage", "runs.play", "runs.accounts", "episodes", "scoring"), "arramon",
    },
    "arramon_server.runs.transfer": {*SHARED, *server("runs.storage")},
    "arramon_server.runs": {
        *SHARED, *WORLD,
        *server("__version__", "runs.storage", "runs.play", "runs.accounts", "runs.results", "episodes"),
    },
    "arramon_server.board": {*SHARED, *server("runs", "episodes", "scoring")},
    "arramon_server.playback": {*SHARED, *WORLD, *server("runs", "episodes", "scoring")},
    "arramon_server.web": {
        *SHARED, *WORLD,
        *server("__version__", "board", "runs", "episodes", "scoring", "playback", "configuration"),
    },
    "arramon_server.api": {
        *SHARED, *WORLD, *server("__version__", "board", "runs", "episodes", "scoring", "configuration"), "arramon",
    },
    "arramon_server.configuration": {*SHARED, *WORLD, *server("runs.play.clocks", "runs.play.note_limits")},
    "arramon_server.process": {
        *SHARED, *WORLD, *server("__version__", "api", "board", "web", "runs", "episodes", "configuration"), "arramon",
    },
    "arramon_dataset": {
        *READING, *WORLD, "arramon_lang",
        *server("scoring", "runs.play.session", "runs.play.worlds"),  # Agents are tried by the very rules.
        # The follower, which is an agent, tries every instruction.
        *client("agent", "plugin.loader", "transport.images", "local.lifeline", "local.cores"),
    },
    "arramon_dataset.commands": {
        *READING, *server("__version__", "commands", "configuration.config", "runs.storage.journal"),
        "arramon_dataset",
        "arramon_lang.quality",
    },
    "arramon_dataset.environments": {
        *READING, *WORLD, *server("scoring", "runs.play.session", "runs.play.worlds", "api.messages"),
        "arramon_dataset.generation.room_tasks", "arramon_dataset.pictures", "arramon_lang", "arramon.v1.chain",
        # It is the backend of the client's environments, in the client's own types.
        *client("agent", "environments.backend", "errors", "plugin.loader"),
    },
    "arramon_dataset.demonstrations": {
        *READING, *WORLD,
        *server("__version__", "runs.play.session", "runs.play.worlds", "runs.results.reports", "runs.storage"),
        "arramon_dataset.environments", "arramon_dataset.parallel",
        *client("agent", "environments"),  # What is exported are the observations of the client's environments.
    },
    "arramon_collecting": {  # Pages of the server, and a host's commands: both may use what theirs use.
        *SHARED, *WORLD,
        *server("__version__", "board", "commands", "configuration", "episodes", "playback", "runs", "scoring", "web"),
        "arramon_client", "arramon_dataset", "arramon_lang",
    },
    "arramon_collecting.rules": {*SHARED, *server("scoring"), "arramon_collecting.settings"},
    "arramon_collecting.storage": {
        *SHARED, *server("runs.storage"), "arramon_collecting.rules", "arramon_collecting.settings",
    },
    "arramon_agents": {"arramon_client", "arramon", "arramon_lang"},
    "arramon_agents.pretrained": set(),
    "arramon_agents.perception": {
        "arramon_agents.pretrained", "arramon_agents.weights", "arramon_agents.compilation",
        "arramon", "arramon_client", "arramon_lang",
        "arramon_agents.training", "arramon_agents.simulated", "arramon_agents.process_settings",  # To train the eyes.
    },
    "arramon_agents.mapping": {
        "arramon_agents.perception", "arramon_agents.compilation", "arramon_client", "arramon_lang",
    },
    "arramon_agents.reading": {
        "arramon_agents.pretrained", "arramon_agents.weights", "arramon", "arramon_client",
        "arramon_lang",
        "arramon_agents.perception.eyes.vocabulary",  # It reads the names of what can be seen.
        "arramon_agents.training", "arramon_agents.simulated", "arramon_agents.process_settings",  # To train it.
    },
    "arramon_agents.training": {  # What trainings share: it imports no agent.
        "arramon_agents.weights", "arramon_agents.perception", "arramon_agents.simulated", "arramon_client",
        "arramon_dataset.parallel", "arramon_lang",
    },
    "arramon_agents.simulated": {  # For training alone: no agent imports it at play.
        *WORLD, *server("episodes", "errors", "scoring"), "arramon_dataset", "arramon_agents.mapping",
        "arramon_agents.process_settings", "arramon_agents.compilation",
        "arramon_agents.perception", "arramon_agents.reading", "arramon_agents.vl_map", "arramon_client",
        "arramon_lang",
    },
    "arramon_client": {"arramon"},
    "arramon_lang": set(),
}  # fmt: skip
FOLDERS = {
    "arramon_server": "server", "arramon_dataset": "dataset", "arramon_agents": "agents", "arramon_lang": "lang",
    "arramon_client": "clients/python/arramon_client", "arramon_collecting": "collecting",
}  # fmt: skip
OURS = (*FOLDERS, "arramon", "tests", "examples")


def imports(path: Path) -> Iterator[str]:
    """The full names of everything that a module imports: `package.module` or `package.module.name`."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def folder_of(package: str) -> Path:
    """The folder of an installed package: the names of those at the top level are others than their folders'."""
    top, *parts = package.split(".")
    return ROOT.joinpath(FOLDERS[top], *parts)


def sources(package: str) -> list[Path]:
    """The modules of a package, without those of a subpackage that has a line of its own."""
    others = [folder_of(other) for other in ALLOWED if other.startswith(package + ".")]
    return [
        path
        for path in folder_of(package).rglob("*.py")
        if "_pb2" not in path.name and "versions" not in path.parts and not any(o in path.parents for o in others)
    ]


def is_within(name: str, package: str) -> bool:
    return name == package or name.startswith(package + ".")


@pytest.mark.parametrize("package", ALLOWED)
def test_packages_import_only_allowed_packages(package: str) -> None:
    found = sources(package)
    assert found
    for path in found:
        for name in imports(path):
            if name.split(".")[0] in OURS:
                is_allowed = any(is_within(name, each) for each in {package, WORLD_CONSTANTS, *ALLOWED[package]})
                assert is_allowed, f"{path.relative_to(ROOT)} imports {name}"


def test_every_server_package_has_an_import_rule() -> None:
    """Not the command line, which may import everything."""
    packages = {path.parent.name for path in (ROOT / "server").glob("*/__init__.py")} - {"commands"}
    assert server(*packages) <= ALLOWED.keys()


def test_the_server_imports_nothing_of_dataset_languages_and_agents() -> None:
    """Neither its packages nor its command line, nor modules such as `backup`: others register commands and pages."""
    found = list((ROOT / "server").rglob("*.py"))
    assert found
    for path in found:
        for name in imports(path):
            top = name.split(".")[0]
            others = {"arramon_collecting", "arramon_dataset", "arramon_lang", "arramon_agents"}
            assert top not in others, f"{path} imports {name}"


def test_serve_starts_where_no_other_package_is_installed(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    code = (
        "import sys; sys.modules.update(dict.fromkeys("
        "['arramon_collecting', 'arramon_dataset', 'arramon_lang', 'arramon_agents'])); "
        "from arramon_server.__main__ import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, "serve", "--data", str(tmp_path), "--listen", "127.0.0.1:0"]
    command += ["--web", "127.0.0.1:0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path) as process:
        assert process.stdout is not None
        said = next((line for line in process.stdout if line.startswith("listening on ")), "")
        process.terminate()
        _, errors = process.communicate()
    assert said, errors
    assert process.returncode == 0, errors


def test_serve_imports_no_dataset_language_or_agent_code() -> None:
    """Neither when it is started, with all of its pages, nor when it plays."""
    code = (
        "import sys, arramon_server.commands.serve, arramon_server.process.server_parts; "
        "import arramon_server.process.workers, arramon_server.web.pages; "
        "print([name for name in sys.modules if name.startswith("
        "('arramon_collecting', 'arramon_dataset', 'arramon_lang', 'arramon_agents', 'torch'))])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == "[]"


def test_no_agent_imports_what_trains_it() -> None:
    """Neither the server nor simulated worlds nor training, by any way from the modules of the entry points."""
    uses = import_cycles.graph(FOLDERS, in_packages=False)
    project = tomllib.loads((ROOT / "packages" / "agents" / "pyproject.toml").read_text())["project"]
    open_ones = {entry.split(":")[0] for entry in project["entry-points"]["arramon.agents"].values()}
    reached: set[str] = set()
    while open_ones:
        module = open_ones.pop()
        reached.add(module)
        if not is_within(module, "arramon_client"):  # It finds a server in this process, if one is installed.
            open_ones |= uses.get(module, set()) - reached
    assert "arramon_agents.vl_grounded.network" in reached
    trains = re.compile(
        r"arramon_server|arramon_dataset|arramon_agents\.(.*\.)?(learning|training|simulated|train|recipe)\b"
    )
    assert not [module for module in reached if trains.match(module)]


def test_agents_at_play_import_nothing_of_the_server() -> None:
    """Nor what trains them."""
    code = (
        "import sys, arramon_agents.seeing_follower, arramon_agents.vl_map.agent, arramon_agents.vl_grounded.agent; "
        "import arramon_agents.perception.eyes.encoder; "
        "print([name for name in sys.modules "
        "if name.startswith(('arramon_server', 'arramon_dataset')) or 'simulated' in name])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == "[]"


def test_no_modules_import_each_other() -> None:
    assert [*import_cycles.cycles(import_cycles.graph(FOLDERS, in_packages=False))] == []


def test_no_packages_import_each_other() -> None:
    """Not those of the agents: a folder holds what plays beside what trains it, which uses all the others."""
    folders = {package: folder for package, folder in FOLDERS.items() if package != "arramon_agents"}
    assert [*import_cycles.cycles(import_cycles.graph(folders, in_packages=True))] == []


@pytest.mark.parametrize(
    ("imported", "expected"),
    [
        ({"a": "bc", "b": "d", "c": "d", "d": ""}, []),
        ({"a": "b", "b": "c", "c": "a", "d": "a"}, [set("abc")]),
        ({"a": "b", "b": "a", "c": "d", "d": "ce", "e": "a"}, [set("ab"), set("cd")]),
    ],
)
def test_cycles_of_a_graph(imported: dict[str, str], expected: list[set[str]]) -> None:
    assert [*import_cycles.cycles({name: set(others) for name, others in imported.items()})] == expected


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
        r"`((?:server|dataset|collecting|clients|agents|lang|proto|tests|benchmarks)/[\w/.-]*)`",
        (ROOT / "CONTRIBUTING.md").read_text(),
    ):
        assert "LANGUAGE" in path or "lang/xx" in path or (ROOT / path).exists(), path


def test_only_one_file_imports_pybullet() -> None:
    everywhere = [path for folder in FOLDERS.values() for path in (ROOT / folder).rglob("*.py")]
    assert [path.name for path in everywhere if "pybullet" in set(imports(path))] == ["bullet.py"]


def test_only_agents_may_import_torch() -> None:
    for folder in ("server", "dataset", "collecting", "clients", "proto", "lang"):
        for path in (ROOT / folder).rglob("*.py"):
            assert not {"torch", "transformers"} & {name.split(".")[0] for name in imports(path)}, path


def test_client_has_only_the_listed_dependencies() -> None:
    project = tomllib.loads((ROOT / "clients" / "python" / "pyproject.toml").read_text())["project"]
    needs = {dependency.split("=")[0].split(">")[0] for dependency in project["dependencies"]}
    assert needs == {"cryptography", "grpcio", "numpy", "protobuf", "rich", "simplejpeg", "zstandard"}


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

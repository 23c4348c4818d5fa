"""The client's messages on a machine with neither the server nor the project's agents."""

import subprocess
from importlib.metadata import distribution
from pathlib import Path

import pytest

from tests import ROOT
from tests.virtual_environments import Environment


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of an environment with the client, in place, and what it requires."""
    client = distribution("arramon-client")
    required = [line for line in client.requires or () if "extra ==" not in line]
    environment = Environment(tmp_path_factory.mktemp("alone"), [], required)
    (environment.site / "client.pth").write_text(f"{ROOT / 'clients' / 'python'}\n")
    (metadata,) = {file.parts[0] for file in client.files or () if file.parts[0].endswith(".dist-info")}
    (environment.site / metadata).symlink_to(Path(str(client.locate_file(metadata))))
    return environment.folder / "bin" / "python"


def said(python: Path, folder: Path, *arguments: str) -> str:
    """Run the client in a folder with an agent `mine`, where it must fail; return its standard error."""
    (folder / "mine.py").write_text(
        "class Agent:\n sensors = ()\n def begin(self, e): pass\n def act(self, o): return [0 for _ in o]\n"
    )
    command = [str(python), "-m", "arramon_client", "--lang", "en", *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode in (1, 2), done
    assert done.stdout == ""
    return done.stderr


def test_missing_project_agents_are_explained(python: Path, tmp_path: Path) -> None:
    assert said(python, tmp_path, "--agent", "agents.random_walk") == (
        "error: no agent 'agents.random_walk': there is no module agents installed or in the working directory "
        f"{tmp_path}. ArraMon's agents are in the package arramon-agents, which is not installed.\n"
    )


def test_missing_server_is_reported_before_episodes_are_generated(python: Path, tmp_path: Path) -> None:
    assert said(python, tmp_path, "--agent", "mine") == (
        "error: without --server the client starts an embedded server, but arramon-server is not installed: "
        "install it, or name a server with --server HOST:PORT\n"
    )
    assert not (tmp_path / "arramon-data").exists()

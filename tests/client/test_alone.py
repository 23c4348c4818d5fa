"""The client's messages on a machine with neither the server nor the project's agents."""

import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

from tests import ROOT


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of an environment with the client, the protocol and their dependencies."""
    folder = tmp_path_factory.mktemp("alone")
    venv.create(folder, symlinks=True)
    (packages,) = (folder / "lib").glob("python*/site-packages")
    # What a .pth file names is not searched for others: what is installed in place, as the server, stays behind.
    paths = (ROOT / "clients" / "python", ROOT / "proto", sysconfig.get_path("purelib"))
    (packages / "client.pth").write_text("".join(f"{path}\n" for path in paths))
    python = folder / "bin" / "python"
    if subprocess.run([python, "-P", "-c", "import server"], capture_output=True, check=False).returncode == 0:
        pytest.skip("the server is installed as a copy; `scripts/setup dev` installs it in place")
    return python


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
        f"{tmp_path}. ArraMon's agents are installed with the server: run `pip install .` in a clone of its "
        "repository.\n"
    )


@pytest.mark.parametrize("of_others", [False, True])
def test_missing_server_is_reported_before_episodes_are_generated(
    python: Path, tmp_path: Path, of_others: bool
) -> None:
    if of_others:  # A folder of the same name in the working directory is not meant.
        (tmp_path / "server").mkdir()
        (tmp_path / "server" / "__init__.py").touch()
    assert said(python, tmp_path, "--agent", "mine") == (
        "error: without --server the client starts an embedded server, but arramon-server is not installed: "
        "install it, or name a server with --server HOST:PORT\n"
    )
    assert not (tmp_path / "arramon-data").exists()


@pytest.mark.parametrize("program", [["-m", "arramon_client"], ["-c", "import arramon_client"]])
def test_a_missing_contract_is_named_in_the_first_line(tmp_path: Path, program: list[str]) -> None:
    """Where the client's wheel was installed without what it requires."""
    shutil.copytree(ROOT / "clients" / "python" / "arramon_client", tmp_path / "arramon_client")
    # Without site-packages: the copy is all that there is.
    done = subprocess.run(
        [sys.executable, "-S", *program], cwd=tmp_path, env={}, capture_output=True, text=True, timeout=60, check=False
    )
    said = "arramon-client needs arramon-proto, the contract's package, beside it: pip install arramon_proto-*.whl"
    assert done.returncode == 1
    assert said in (done.stderr if program[0] == "-c" else done.stderr.splitlines()[0])
    assert ("Traceback" in done.stderr) == (program[0] == "-c")

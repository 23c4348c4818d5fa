"""The folder `deploy/openenv`: valid for OpenEnv's own command, and its server answers as OpenEnv expects."""

import json
import os
import shutil
import subprocess
import time
import urllib.request
from pathlib import Path

import pytest

from tests import ROOT, tiny
from tests.doors.installed import framework_python
from tests.ports import free_port
from tests.serving import Server

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def openenv(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return framework_python(tmp_path_factory, "openenv")


def validate(openenv: Path, *arguments: str) -> dict[str, object]:
    command = [str(openenv), "-m", "openenv.cli", "validate", *arguments]
    environment = {"PATH": os.environ["PATH"], "HOME": str(openenv.parent), "LANG": "C.UTF-8"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=100)
    report: dict[str, object] = json.loads(done.stdout)
    assert (done.returncode == 0) == report["passed"], done.stderr
    return report


def test_the_folder_is_valid_with_its_lock_file(openenv: Path, tmp_path: Path) -> None:
    folder = tmp_path / "deploy" / "openenv"
    shutil.copytree(ROOT / "deploy" / "openenv", folder, ignore=shutil.ignore_patterns("uv.lock", ".venv"))
    shutil.copytree(ROOT / "clients" / "python", tmp_path / "clients" / "python")
    report = validate(openenv, str(folder), "--json")
    assert report["issues"] == ["Missing uv.lock - run 'uv lock' to generate it"]
    environment = {**os.environ, "UV_PYTHON": str(openenv), "UV_CACHE_DIR": str(tmp_path / "cache")}
    command = [str(openenv.with_name("uv")), "lock", "--quiet"]
    subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True, timeout=200)
    assert validate(openenv, str(folder), "--json")["issues"] == []


def test_its_server_is_valid(openenv: Path, tmp_path: Path) -> None:
    tiny.write(tmp_path / "data")
    arramon = Server(tmp_path / "data", "127.0.0.1:0")
    port = str(free_port())
    environment = {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path), "LANG": "C.UTF-8", "ARRAMON_SERVER": arramon.address}
    command = [str(openenv), "-m", "server.app", "--port", port]
    with subprocess.Popen(command, cwd=ROOT / "deploy" / "openenv", env=environment, stderr=subprocess.PIPE) as served:
        try:
            wait_for(f"http://127.0.0.1:{port}/health", served)
            report = validate(openenv, "--url", f"http://127.0.0.1:{port}", "--timeout", "60")
            assert report["passed"], report
        finally:
            served.terminate()
    assert arramon.stop() == 0


def wait_for(address: str, served: "subprocess.Popen[bytes]") -> None:
    while True:
        assert served.poll() is None, served.stderr and served.stderr.read().decode()
        try:
            with urllib.request.urlopen(address, timeout=5):
                return
        except OSError:
            time.sleep(0.1)

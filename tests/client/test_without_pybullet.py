"""The whole way, client and embedded server, in a Python that has no pybullet: the scores are the same."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from arramon_dataset.release.importer import import_release
from tests import ROOT

SAMPLE = ROOT / "examples" / "sample" / "sample.json"
WITHOUT = "import sys\nsys.modules['pybullet'] = None\n"
"""Found by every Python process that is started with its folder in PYTHONPATH, before anything else."""


def result(folder: Path, name: str, **variables: str) -> dict[str, Any]:
    """The receipt of a run of two episodes, without what differs from run to run."""
    command = [sys.executable, "-m", "arramon_client", "--agent", "agents.random_walk", "--lang", "en", "--quiet"]
    command += ["--data", str(folder / "data"), "--episodes", "2", "--output", str(folder / name)]
    done = subprocess.run(
        command, cwd=ROOT, env={**os.environ, **variables}, capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
    (path,) = (folder / name).glob("*.receipt.json")
    content: dict[str, Any] = json.loads(json.loads(path.read_text())["payload"])
    kept = {key: content[key] for key in ("causes", "data_hash", "score_signature", "scores")}
    return {**kept, "episodes": [(one["episode_id"], one["steps"], one["scores"]) for one in content["episodes"]]}


def test_an_evaluation_without_pybullet_has_the_same_scores(tmp_path: Path) -> None:
    import_release([SAMPLE], tmp_path / "data")
    (tmp_path / "blocked").mkdir()
    (tmp_path / "blocked" / "sitecustomize.py").write_text(WITHOUT)
    path = os.pathsep.join((str(tmp_path / "blocked"), os.environ.get("PYTHONPATH", "")))
    checked = subprocess.run(
        [sys.executable, "-c", "import pybullet"],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        check=False,
    )
    assert b"ModuleNotFoundError" in checked.stderr
    without = result(tmp_path, "without", PYTHONPATH=path)
    assert [steps for _, steps, _ in without["episodes"]] == [302, 331]
    assert without == result(tmp_path, "usual")

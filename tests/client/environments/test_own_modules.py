"""Environments in a learner's folder, whose modules have the names of this project's folders."""

import subprocess
import sys
from pathlib import Path

NAMES = {"agents": "agents/__init__.py", "dataset": "dataset.py", "lang": "lang/__init__.py", "server": "server.py"}
"""The learner's packages and modules, and their files."""

PROGRAM = """
import sys
import gymnasium
import agents, dataset, lang, server
import arramon_client.environments

options = {"data": sys.argv[1], "split": "tiny", "image_size": 16, "expert": "shortest"}

if __name__ == "__main__":
    env = gymnasium.make("arramon/ArraMon-v0", **options)
    env.reset(seed=0)
    env.step(0)
    for context in ("forkserver", "spawn"):
        envs = gymnasium.make_vec("arramon/ArraMon-v0", num_envs=2, processes=2, context=context, **options)
        envs.reset(seed=0)
        envs.step([0, 1])
        envs.close()
    print(*(module.OWN for module in (agents, dataset, lang, server)))
"""


def test_environments_play_beside_modules_of_any_name(data: Path, tmp_path: Path) -> None:
    """In this process and in those of a vector environment, which import the learner's program again."""
    for name, file in NAMES.items():
        path = tmp_path / file
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"OWN = {name!r}")
    (tmp_path / "learn.py").write_text(PROGRAM)
    command = [sys.executable, "learn.py", str(data)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == list(NAMES)

"""What a learner waits for until its first step: only what it needs is imported."""

import subprocess
import sys
from pathlib import Path

import pytest

HEAVY = ("PIL", "aiohttp", "alembic", "cryptography", "google.protobuf", "grpc", "jinja2", "pybullet", "rich",
         "arramon_lang", "arramon_dataset.generation", "arramon_dataset.instructions", "arramon_dataset.pictures",
         "arramon_server.api", "arramon_server.board", "arramon_server.process", "arramon_server.runs.accounts",
         "arramon_server.runs.results", "arramon_server.web", "sqlalchemy", "torch")  # fmt: skip
"""Packages that an environment in process does not need. numba imports scipy by itself."""

DRAWING = ("arramon_lang", "arramon_dataset.generation", "arramon_dataset.instructions")
"""Those of them by which tasks in the room alone are drawn."""

PROGRAM = """
import sys
import gymnasium
env = gymnasium.{made}("arramon_client.environments:{name}", {options}, image_size=16)
env.reset(seed=0)
env.step({action})
print(*sys.modules)
"""


MADE = [  # each function with each task, and each of both with a name with and without the namespace
    ("make", "0", "arramon/ArraMon-v0"),
    ("make_vec", "[0]", "ArraMon-v0"),
    ("make", "0", "ArraMonRoom-v0"),
    ("make_vec", "[0]", "arramon/ArraMonRoom-v0"),
]


@pytest.mark.parametrize(("made", "action", "name"), MADE)
def test_the_first_step_imports_only_what_it_needs(
    made: str, action: str, name: str, data: Path, tmp_path: Path
) -> None:
    """Gymnasium itself imports what registers an environment, where its name says so; nothing registers it before."""
    heavy = [each for each in HEAVY if "Room" not in name or each not in DRAWING]
    options = "" if "Room" in name else 'data=sys.argv[1], split="tiny"'
    program = PROGRAM.format(made=made, action=action, name=name, options=options).replace(", ,", ",")
    command = [sys.executable, "-W", "error", "-c", program, str(data)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    imported = done.stdout.split()
    assert "numba" in imported
    assert [each for each in heavy if each in imported] == []


def test_the_public_names_of_the_client_import_nothing(tmp_path: Path) -> None:
    code = "import sys, arramon_client; print(*({'grpc', 'numpy', 'cryptography'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, check=True)
    assert done.stdout.split() == []

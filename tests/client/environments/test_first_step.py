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

PROGRAM = """
import sys
import gymnasium, arramon_client.environments
env = gymnasium.{made}("arramon/ArraMon-v0", data=sys.argv[1], split="tiny", image_size=16)
env.reset(seed=0)
env.step({action})
print(*sys.modules)
"""


@pytest.mark.parametrize(("made", "action"), [("make", "0"), ("make_vec", "[0]")])
def test_the_first_step_imports_only_what_it_needs(data: Path, tmp_path: Path, made: str, action: str) -> None:
    program = PROGRAM.format(made=made, action=action)
    command = [sys.executable, "-c", program, str(data)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=True)
    imported = done.stdout.split()
    assert "numba" in imported
    assert [name for name in HEAVY if name in imported] == []


def test_the_public_names_of_the_client_import_nothing(tmp_path: Path) -> None:
    code = "import sys, arramon_client; print(*({'grpc', 'numpy', 'cryptography'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, check=True)
    assert done.stdout.split() == []

"""Training where no extra is installed: the message names it."""

import subprocess
import sys

import pytest

from arramon_agents.train import trainings
from tests import ROOT

MISSING = ("torch", "safetensors", "sentencepiece", "transformers", "gymnasium", "tensorboardX", "zstandard")

CODE = f"""
import sys
sys.modules.update(dict.fromkeys({MISSING}))
from arramon_agents.train import main
sys.exit(main(sys.argv[1:]))
"""


def arramon_train(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run `arramon-train` in a process that cannot import the extras' packages."""
    return subprocess.run(
        [sys.executable, "-c", CODE, *arguments], capture_output=True, text=True, cwd=ROOT, check=False
    )


def test_help_needs_no_extra() -> None:
    done = arramon_train("--help")
    assert (done.stderr, done.returncode) == ("", 0)
    assert "--agent" in done.stdout


@pytest.mark.parametrize("agent", ["vl", "eyes"])
def test_the_message_names_the_extra(agent: str) -> None:
    assert agent in trainings()
    done = arramon_train("--agent", agent)
    assert done.returncode == 1
    assert done.stderr.startswith("error: training needs torch and ")
    assert "`pip install 'arramon-agents[training]'`" in done.stderr

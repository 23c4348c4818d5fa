"""Speed of each environment, measured over one step."""

import json
import re
from pathlib import Path

from tests.benchmarks.command import numbers, printed, run

MODULE = "benchmarks.simulation.environments"


def test_every_row_is_measured(many: Path, tmp_path: Path) -> None:
    file = tmp_path / "rows.json"
    lines = printed(MODULE, "--data", many, "--steps", 1, "--rounds", 1, "--json", file)
    assert lines[0] == "split tiny, 32 episodes"
    ours = [name for name in json.loads(file.read_text()) if not re.match(r"Mini", name)]
    assert len(ours) == 15
    for name in ours:
        assert numbers(lines, f"{name}  ")[0] > 0
    assert numbers(lines, "bare camera with rules, 224  ")[1] == 1.0


def test_steps_that_no_episode_has(many: Path) -> None:
    done = run(MODULE, "--data", many, "--steps", 0)
    assert done.returncode == 2
    assert "--steps is 0, expected 1 to 599" in done.stderr

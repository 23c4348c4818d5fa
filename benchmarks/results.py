"""The table of agents in docs/results.md, from runs of `arramon-client` on the embedded server.

    python benchmarks/results.py [--data DIR] [--runs DIR] [--episodes N] [--agents A,B] [--splits S,T] [--page FILE]

Each agent plays the first N episodes of each split in each language. Runs that are in the folder of runs already, of N
episodes or more with the same weights, are not played again: after an interruption the command goes on; name another
folder for other data. Differences are over the episodes that both agents played. A
learned agent's weights are those that come along. "PTC alone" is the placement after perfect navigation, played in
process by the same rules.
"""

import argparse
import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents.learning.checkpoint import SUFFIX, WEIGHTS
from agents.learning.rollouts import Plan, mean, play
from arramon_client import load_agent

AGENTS = ("random_walk", "language_only", "vision_only", "vl", "follower", "shortest_path")
LANGUAGES = ("en", "hi")
SPLITS = ("val_seen", "val_unseen")
COLUMNS = ("nDTW", "CTC-0", "CTC-3", "CTC-5", "CTC-7", "rPOD@CTC-3", "PTC@CTC-3")
COMPARED = (("vl", "vision_only"), ("vl", "language_only"), ("vision_only", "random_walk"),
            ("language_only", "random_walk"))  # fmt: skip
"""Pairs of agents whose difference is shown."""

PRIVILEGED = {"shortest_path": ("--sensors", "pose,oracle")}

PAPER = {
    "val_seen": {
        "R/W": (0.045, 0.000, 0.030, 0.054, 0.092, 0.005, 0.001),
        "L/O": (0.110, 0.000, 0.044, 0.095, 0.147, 0.023, 0.017),
        "V/O": (0.055, 0.000, 0.043, 0.062, 0.087, 0.008, 0.001),
        "V/L": (0.135, 0.000, 0.098, 0.149, 0.200, 0.058, 0.044),
        "human workers": (0.671, 1.000, 1.000, 1.000, 1.000, 0.879, 0.861),
    },
    "val_unseen": {
        "R/W": (0.045, 0.000, 0.024, 0.043, 0.075, 0.005, 0.001),
        "L/O": (0.105, 0.000, 0.029, 0.068, 0.126, 0.017, 0.013),
        "V/O": (0.043, 0.000, 0.031, 0.057, 0.085, 0.007, 0.002),
        "V/L": (0.109, 0.000, 0.062, 0.108, 0.153, 0.036, 0.028),
        "human workers": (0.670, 1.000, 1.000, 1.000, 1.000, 0.869, 0.856),
    },
}
"""The paper's table 2: other data, English by people, in the original simulator."""

BEGIN, END = "<!-- tables: benchmarks/results.py -->", "<!-- end of tables -->"


@dataclass(frozen=True)
class Played:
    """One agent on one split in one language: the client's results, and placement after perfect navigation."""

    agent: str
    split: str
    language: str
    results: dict[str, Any]
    alone: float | None

    def of(self, metric: str) -> dict[str, float]:
        """Return a metric of each episode, both turns' mean, by id."""
        return {
            each["episode_id"]: sum(turn[metric] for turn in each["turns"].values()) / len(each["turns"])
            for each in self.results["episodes"]
        }


def main() -> None:
    """Play what was not played yet, and write the page's tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("arramon-data"))
    parser.add_argument("--runs", type=Path, default=Path("arramon-results/table"))
    parser.add_argument("--episodes", type=int, default=100)
    parser.add_argument("--agents", default=",".join(AGENTS))
    parser.add_argument("--splits", default=",".join(SPLITS))
    parser.add_argument("--page", type=Path, default=Path("docs/results.md"))
    given = parser.parse_args()
    played = [
        play_one(given, agent, split, language)
        for split in given.splits.split(",")
        for agent in given.agents.split(",")
        for language in LANGUAGES
    ]
    tables = "\n\n".join(section(split, played) for split in given.splits.split(","))
    page = given.page.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    given.page.write_text(f"{before}{BEGIN}\n\n{tables}\n\n{END}{rest.split(END)[1]}", encoding="utf-8")


def play_one(given: argparse.Namespace, agent: str, split: str, language: str) -> Played:
    """Return what an agent reaches on a split in a language, from the folder of runs or by playing."""
    weights = WEIGHTS / f"{agent}{SUFFIX}"
    mark = hashlib.sha256(weights.read_bytes()).hexdigest()[:8] if weights.exists() else "fixed"
    name = f"{agent}-{mark}-{split}-{language}"
    there = {int(each.stem.rsplit("-", 1)[1]): each for each in given.runs.glob(f"{name}-*.json")}
    most = max(there, default=0)
    path = there[most] if most >= given.episodes else given.runs / f"{name}-{given.episodes}.json"
    if not path.exists():
        _run(given, agent, split, language, path)
    kept = json.loads(path.read_text())
    if weights.exists() and "alone" not in kept:
        plan = Plan(given.data, split, (language,), given.episodes, 224, phases=("assembly",))
        kept["alone"] = mean(play(load_agent(f"agents.{agent}"), plan), "PTC")
        path.write_text(json.dumps(kept))
    return Played(agent, split, language, kept, kept.get("alone"))


def section(split: str, played: Sequence[Played]) -> str:
    """Return a split's tables in Markdown."""
    here = [each for each in played if each.split == split]
    lines = [f"## {split}", "", _header("agent", "language", "episodes", *COLUMNS, "PTC alone")]
    for each in here:
        count = len(each.results["episodes"])
        values = [sum(each.of(metric).values()) / count for metric in COLUMNS]
        alone = "" if each.alone is None else f"{each.alone:.3f}"
        lines.append(f"| `{each.agent}` | {each.language} | {count} | {_numbers(values)} | {alone} |")
    for name, row in PAPER.get(split, {}).items():
        lines.append(f"| *the paper's {name}: other data* | *en* | | {_numbers(row)} | |")
    lines += ["", _header("difference, paired by episode", "language", "nDTW", "CTC-3")]
    by_key = {(each.agent, each.language): each for each in here}
    for better, worse in COMPARED:
        for language in LANGUAGES:
            pair = by_key.get((better, language)), by_key.get((worse, language))
            if pair[0] and pair[1]:
                shown = [_difference(pair[0].of(metric), pair[1].of(metric)) for metric in ("nDTW", "CTC-3")]
                lines.append(f"| `{better}` - `{worse}` | {language} | {' | '.join(shown)} |")
    return "\n".join(lines)


def _run(given: argparse.Namespace, agent: str, split: str, language: str, path: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        command = [
            str(Path(sys.executable).with_name("arramon-client")), "--agent", f"agents.{agent}", "--lang", language,
            "--split", split, "--episodes", str(given.episodes), "--data", str(given.data), "--output", folder,
            "--parallel", "16", "--quiet", *PRIVILEGED.get(agent, ()),
        ]  # fmt: skip
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        (results,) = [each for each in Path(folder).glob("*.json") if not each.name.endswith(".receipt.json")]
        path.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(results, path)
    print(f"{agent} {split} {language}: done", file=sys.stderr, flush=True)


def _difference(better: dict[str, float], worse: dict[str, float]) -> str:
    """Return the mean difference over common episodes with its 95% interval, by the normal approximation."""
    differences = np.array([better[each] - worse[each] for each in sorted(better.keys() & worse.keys())])
    half = 1.96 * differences.std(ddof=1) / len(differences) ** 0.5
    return f"{differences.mean():+.3f} ({differences.mean() - half:+.3f} to {differences.mean() + half:+.3f})"


def _header(*names: str) -> str:
    return f"| {' | '.join(names)} |\n|{' --- |' * len(names)}"


def _numbers(values: Sequence[float]) -> str:
    return " | ".join(f"{value:.3f}" for value in values)


if __name__ == "__main__":
    main()

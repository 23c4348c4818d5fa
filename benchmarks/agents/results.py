"""Scores of agents in runs of `arramon-client` on the embedded server: the tables of docs/results/agents.md.

    python -m benchmarks.agents.results [--data DIR] [--runs DIR] [--weights DIR ...] [--episodes N] [--agents A,B]
                                        [--splits S,T] [--hidden-agents A,B] [--page FILE] [--play-only]

Each agent plays each split in each language, whole or its first N episodes; an agent that has learned, with its
weights in each folder of `--weights`, one for each seed (without it, with the shipped ones). Runs in the
folder of runs, of N episodes or more with the same weights, are reused, so that an interrupted command can be resumed;
use another folder for other data. With `--play-only` the page stays as it is: two commands with
different agents can play side by side. "PTC alone" is the placement after perfect navigation, played in process by the
same rules. Of the hidden split, which some agents play with the weights of the first folder, the server reports only
means and intervals.
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

from arramon_agents.training.rollouts import RolloutPlan, play
from arramon_agents.weights import SHIPPED, file_of
from arramon_client import load_agent
from benchmarks.agents.results_tables import ANY, AgentScores, HiddenScores, hidden_section, section
from benchmarks.agents.study import write_page
from benchmarks.common import parser_of

TRAINED_AGENTS = ("language_only", "vision_only", "vl", "vl_sentencepiece", "vl_multilingual", "vl_grounded", "vl_map")
"""Agents that have learned; the one that reads by a pretrained encoder needs a package that is no part of the extra."""

AGENTS = (
    "random_walk", "language_only", "vision_only", "vl", "vl_grounded", "vl_grounded+segmentation", "vl_map",
    "vl_map+segmentation", "seeing_follower", "follower", "shortest_path",
)  # fmt: skip
"""Agents played by default; the suffix `+segmentation` adds that sensor."""

HIDDEN, HIDDEN_AGENTS = "test_unseen", ("vl", "vl_map")
"""The hidden split, and the agents that play it."""

LANGUAGE_BLIND = ("random_walk", "vision_only", "shortest_path")
"""Agents whose play does not depend on the language: played in the first one, shown once."""

LANGUAGES = ("en", "hi")
SPLITS = ("val_seen", "val_unseen")
SENSORS = {"shortest_path": "pose,oracle", "random_walk": "pose"}
"""Sensors that replace an agent's own; random walk uses none, and images would take time."""

CHANCE = "random_walk"
CHANCE_SEEDS = (0, 1, 2)
"""Seeds of the agent with random actions."""

NOT_PLACED_ALONE = ("shortest_path",)
"""Agents that do not play placement after perfect navigation, as they know the ground truth."""

BEGIN, END = "<!-- tables: benchmarks/agents/results.py -->", "<!-- end of tables -->"


@dataclass(frozen=True)
class AgentSetup:
    """An agent with its seed, its weights if it is trained, and an additional sensor."""

    agent: str
    seed: int
    weights: Path | None
    sensor: str = ""

    @property
    def name(self) -> str:
        """Name in the tables."""
        return f"{self.agent} sensor={self.sensor}" if self.sensor else self.agent

    @property
    def arguments(self) -> dict[str, object]:
        """Arguments of the agent."""
        if self.weights is not None:
            own: dict[str, object] = {"sensor": self.sensor} if self.sensor else {}
            return {"weights": str(self.weights), **own}
        return {"seed": self.seed} if self.agent == CHANCE else {}

    @property
    def run_name(self) -> str:
        """Name of its runs, which includes a hash of its weights."""
        if self.weights is not None:
            agent = f"{self.agent}+{self.sensor}" if self.sensor else self.agent
            return f"{agent}-{hashlib.sha256(self.weights.read_bytes()).hexdigest()[:8]}"
        return f"{self.agent}-{self.seed}"


def main() -> None:
    """Play the missing runs, and write the page's tables."""
    parser = parser_of(__doc__)
    parser.add_argument("--data", type=Path, default=Path("arramon-data"))
    parser.add_argument("--runs", type=Path, default=Path("arramon-results/table"))
    parser.add_argument("--weights", type=Path, nargs="+", default=[SHIPPED], help="a folder for each seed, in order")
    parser.add_argument("--episodes", type=int, default=0, help="the first ones of each split; 0 for all")
    parser.add_argument("--agents", default=",".join(AGENTS))
    parser.add_argument("--splits", default=",".join(SPLITS))
    parser.add_argument("--hidden-agents", default=",".join(HIDDEN_AGENTS), help=f"that play {HIDDEN}; empty for none")
    parser.add_argument("--page", type=Path, default=Path("docs/results/agents.md"))
    parser.add_argument("--play-only", action="store_true", help="do not write the page")
    given = parser.parse_args()
    splits = [split for split in given.splits.split(",") if split]
    runs = play_agents(given, splits)
    hidden = [
        play_hidden(given, setup, language)
        for setup in _setups(given.hidden_agents, given.weights[:1])
        for language in LANGUAGES
    ]
    if given.play_only:
        return
    tables = [section(split, runs) for split in splits]
    if hidden:
        tables.append(hidden_section(HIDDEN, hidden))
    write_page(given.page, BEGIN, END, "\n\n".join(tables))


def play_agents(given: argparse.Namespace, splits: Sequence[str]) -> list[AgentScores]:
    """Return the scores of all given agents on splits in each language, from the folder of runs or by playing."""
    return [
        play_one(given, setup, split, language)
        for setup in _setups(given.agents, given.weights)
        for split in splits
        for language in (LANGUAGES[:1] if setup.agent in LANGUAGE_BLIND else LANGUAGES)
    ]


def _setups(agents: str, folders: Sequence[Path]) -> list[AgentSetup]:
    return [setup for agent in agents.split(",") if agent for setup in setups_of(agent, folders)]


def setups_of(agent: str, folders: Sequence[Path]) -> list[AgentSetup]:
    """Return an agent once for each of its seeds: for one that has learned, the number of its folder from 1 on.

    Raises:
        SystemExit: if no folder has weights of an agent that has learned.
    """
    agent, _, sensor = agent.partition("+")
    if agent not in TRAINED_AGENTS:
        return [AgentSetup(agent, seed, None) for seed in (CHANCE_SEEDS if agent == CHANCE else (0,))]
    files = [file_of(folder, agent) for folder in folders]
    found = [AgentSetup(agent, seed, file, sensor) for seed, file in enumerate(files, 1) if file.exists()]
    if not found:
        sys.exit(f"there are no weights of {agent} in {', '.join(map(str, folders))}")
    return found


def play_one(given: argparse.Namespace, setup: AgentSetup, split: str, language: str) -> AgentScores:
    """Return the scores of an agent on a split in a language, from the folder of runs or by playing."""
    path = _results(given, setup, split, language)
    kept: dict[str, Any] = json.loads(path.read_text())
    if setup.agent not in NOT_PLACED_ALONE and "alone" not in kept:
        plan = RolloutPlan(given.data, split, (language,), len(kept["episodes"]), phases=("assembly",))
        scores = play(load_agent(f"agents.{setup.agent}", setup.arguments), plan)
        kept["alone"] = {episode_id: each["PTC"] for episode_id, each in scores.items()}
        path.write_text(json.dumps(kept))
    shown = ANY if setup.agent in LANGUAGE_BLIND else language
    return AgentScores.of_results(setup.name, setup.seed, split, shown, kept)


def play_hidden(given: argparse.Namespace, setup: AgentSetup, language: str) -> HiddenScores:
    """Return the scores of an agent on the hidden split in a language, from the folder of runs or by playing."""
    whole = argparse.Namespace(**{**vars(given), "episodes": 0})  # A hidden split is played whole.
    kept: dict[str, Any] = json.loads(_results(whole, setup, HIDDEN, language).read_text())
    return HiddenScores(setup.name, setup.seed, language, kept["run"]["episodes"], kept["metrics"])


def _results(given: argparse.Namespace, setup: AgentSetup, split: str, language: str) -> Path:
    """Return the results file of an agent on a split, after playing the run if it is missing."""
    name = f"{setup.run_name}-{split}-{language}"
    runs: Path = given.runs
    whole = runs / f"{name}-all.json"
    parts = {int(each.stem.rsplit("-", 1)[1]): each for each in runs.glob(f"{name}-[0-9]*.json")}
    most = max(parts, default=0)
    if whole.exists() or not given.episodes:
        path = whole
    else:
        path = parts[most] if most >= given.episodes else runs / f"{name}-{given.episodes}.json"
    if not path.exists():
        _play_run(given, setup, split, language, path)
    return path


def _play_run(given: argparse.Namespace, setup: AgentSetup, split: str, language: str, path: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        command = [
            str(Path(sys.executable).with_name("arramon-client")), "--agent", f"agents.{setup.agent}",
            "--lang", language, "--split", split, "--data", str(given.data), "--output", folder,
            "--parallel", "16", "--quiet",
            *(("--episodes", str(given.episodes)) if given.episodes else ()),
            *(("--sensors", SENSORS[setup.agent]) if setup.agent in SENSORS else ()),
            *(part for name, value in setup.arguments.items() for part in ("--agent-arg", f"{name}={value}")),
        ]  # fmt: skip
        if status := subprocess.run(command, check=False, stdout=subprocess.DEVNULL).returncode:
            sys.exit(
                f"{setup.agent} did not play {split} in {language} to the end: its client ended with status {status}"
            )
        (results,) = [each for each in Path(folder).glob("*.json") if not each.name.endswith(".receipt.json")]
        path.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(results, path)
    print(f"{setup.agent}, seed {setup.seed}, {split} {language}: done", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()

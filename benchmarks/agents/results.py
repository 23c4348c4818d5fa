"""The tables of agents in docs/results.md, from runs of `arramon-client` on the embedded server.

    python -m benchmarks.agents.results [--data DIR] [--runs DIR] [--weights DIR ...] [--episodes N] [--agents A,B]
                                        [--splits S,T] [--page FILE] [--part NAME]

Each agent plays the first N episodes of each split in each language; an agent that has learned, with the weights of
each folder of `--weights`, one for each seed (without it, with the shipped ones). Runs that are in the folder of
runs already, of N episodes or more with the same weights, are not played again: after an interruption the command goes
on; name another folder for other data. With `--play-only` the page stays as it is: two commands with different agents
can play side by side. "PTC alone" is the placement after perfect navigation, played in process by the same rules.
"""

import argparse
import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from agents.learning.checkpoint import SUFFIX, WEIGHTS, load_policy
from agents.learning.training.rollouts import Plan, play
from arramon_client import load_agent
from benchmarks.agents.results_tables import Run, part, section

LEARNED = ("language_only", "vision_only", "vl")
TRAINED_ONCE = ("vl_grounded", "vl_map")
"""Agents that have learned as well, but not once for each seed: they play with the shipped weights."""
READ_OTHERWISE = ("vl_sentencepiece", "vl_multilingual")
"""Trained once too; played only if they are named, as the second needs a package that is not of the extra `agents`."""

AGENTS = ("random_walk", *LEARNED, *TRAINED_ONCE, "seeing_follower", "follower", "shortest_path")
LANGUAGES = ("en", "hi")
SPLITS = ("val_seen", "val_unseen")
SENSORS = {"shortest_path": "pose,oracle", "random_walk": "pose"}
"""Sensors of agents that are run with others than their own; random walk uses none, and images take time."""

CHANCE = "random_walk"
CHANCE_SEEDS = (0, 1, 2)
"""The agent whose actions are drawn, and the seeds with which it plays."""

NOT_ALONE = ("shortest_path",)
"""Agents whose placement after perfect navigation is not played: they know the ground truth."""

BEGIN, END = "<!-- tables: benchmarks/agents/results.py -->", "<!-- end of tables -->"


@dataclass(frozen=True)
class Player:
    """An agent as it plays: with which seed, which weights if it has learned, and which sensor if not its own."""

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
    def mark(self) -> str:
        """Name of its runs: other weights have other ones."""
        if self.weights is not None:
            agent = f"{self.agent}+{self.sensor}" if self.sensor else self.agent
            return f"{agent}-{hashlib.sha256(self.weights.read_bytes()).hexdigest()[:8]}"
        return f"{self.agent}-{self.seed}"


def main() -> None:
    """Play what was not played yet, and write the page's tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("arramon-data"))
    parser.add_argument("--runs", type=Path, default=Path("arramon-results/table"))
    parser.add_argument("--weights", type=Path, nargs="+", default=[WEIGHTS], help="a folder for each seed")
    parser.add_argument("--episodes", type=int, default=40)
    parser.add_argument("--agents", default=",".join(AGENTS))
    parser.add_argument("--splits", default=",".join(SPLITS))
    parser.add_argument("--page", type=Path, default=Path("docs/results.md"))
    parser.add_argument("--part", default="", help="of the page: the means alone, between marks of this name")
    parser.add_argument("--play-only", action="store_true", help="do not write the page")
    given = parser.parse_args()
    players = [player for agent in given.agents.split(",") for player in players_of(agent, given.weights)]
    runs = [
        play_one(given, player, split, language)
        for split in given.splits.split(",")
        for player in players
        for language in LANGUAGES
    ]
    if given.play_only:
        return
    write = part if given.part else section
    tables = "\n\n".join(write(split, runs) for split in given.splits.split(","))
    page = given.page.read_text(encoding="utf-8")
    begin = BEGIN.replace(" -->", f" --part {given.part} -->") if given.part else BEGIN
    before, rest = page.split(begin)
    given.page.write_text(f"{before}{begin}\n\n{tables}\n\n{END}{rest.split(END, 1)[1]}", encoding="utf-8")


def players_of(agent: str, folders: list[Path]) -> list[Player]:
    """Return an agent once for each of its seeds; that of a learned one is in its file of weights."""
    agent, _, sensor = agent.partition("+")
    if agent in (*TRAINED_ONCE, *READ_OTHERWISE):
        return [Player(agent, 0, WEIGHTS / f"{agent}{SUFFIX}", sensor)]
    if agent not in LEARNED:
        return [Player(agent, seed, None) for seed in (CHANCE_SEEDS if agent == CHANCE else (0,))]
    files = [folder / f"{agent}{SUFFIX}" for folder in folders]
    return [Player(agent, load_policy(file).about["recipe"]["seed"], file) for file in files]


def play_one(given: argparse.Namespace, player: Player, split: str, language: str) -> Run:
    """Return what an agent reaches on a split in a language, from the folder of runs or by playing."""
    name = f"{player.mark}-{split}-{language}"
    there = {int(each.stem.rsplit("-", 1)[1]): each for each in given.runs.glob(f"{name}-*.json")}
    most = max(there, default=0)
    path = there[most] if most >= given.episodes else given.runs / f"{name}-{given.episodes}.json"
    if not path.exists():
        _play_run(given, player, split, language, path)
    kept: dict[str, Any] = json.loads(path.read_text())
    if player.agent not in NOT_ALONE and "alone" not in kept:
        plan = Plan(given.data, split, (language,), len(kept["episodes"]), 224, phases=("assembly",))
        scores = play(load_agent(f"agents.{player.agent}", player.arguments), plan)
        kept["alone"] = {episode_id: each["PTC"] for episode_id, each in scores.items()}
        path.write_text(json.dumps(kept))
    return Run.of_results(player.name, player.seed, split, language, kept)


def _play_run(given: argparse.Namespace, player: Player, split: str, language: str, path: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        command = [
            str(Path(sys.executable).with_name("arramon-client")), "--agent", f"agents.{player.agent}",
            "--lang", language, "--split", split, "--episodes", str(given.episodes), "--data", str(given.data),
            "--output", folder, "--parallel", "16", "--quiet",
            *(("--sensors", SENSORS[player.agent]) if player.agent in SENSORS else ()),
            *(part for name, value in player.arguments.items() for part in ("--agent-arg", f"{name}={value}")),
        ]  # fmt: skip
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        (results,) = [each for each in Path(folder).glob("*.json") if not each.name.endswith(".receipt.json")]
        path.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(results, path)
    print(f"{player.agent}, seed {player.seed}, {split} {language}: done", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()

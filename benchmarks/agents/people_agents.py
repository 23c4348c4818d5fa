"""The table of agents on people's instructions in docs/results.md.

    python -m benchmarks.agents.people_agents DATA [--split S] [--lang L] [--episodes N] [--runs DIR] [--tuned DIR]
                                              [--agents A,B] [--page FILE] [--play-only]

DATA is a folder of `arramon-server import-release`. Of the split's episodes in playing order every second one may be
learned from. The agents play the first N of the others, with weights that were trained on generated text alone; with
`--tuned`, those that read with the learned reader play with one that was fine-tuned on people's texts as well
(`reader.safetensors` of `python -m agents.learning.tune_reader`). Runs that are in the folder of runs already are not
played again: after an interruption the command goes on. The room is played alone, too, after perfect navigation.
"""

import argparse
import hashlib
import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from agents.learning.reader.reader import WEIGHTS as READER
from agents.learning.simulated.people import halves
from agents.learning.training.rollouts import Plan, play
from arramon_client import load_agent
from arramon_client.environments.backend import PHASES
from server.episodes.splits import folder_of, read_split

READING = ("vl_map", "seeing_follower")
"""Agents that read with the learned reader, which can be fine-tuned."""

AGENTS = ("random_walk", "language_only", "vision_only", "vl", "vl_grounded", *READING, "follower")
METRICS = ("nDTW", "CTC-3", "PTC@CTC-3")
ALONE = "PTC alone"
TUNED = "fine-tuned"

BEGIN, END = "<!-- tables: benchmarks/agents/people_agents.py -->", "<!-- end of people's tables -->"

Scores = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Player:
    """An agent, and the reader that was fine-tuned for it, if there is one."""

    agent: str
    reader: Path | None

    @property
    def arguments(self) -> dict[str, object]:
        """Arguments of the agent."""
        return {"reader": str(self.reader)} if self.reader else {}

    @property
    def mark(self) -> str:
        """Name of its runs: another reader has other ones."""
        reader = self.reader or (READER if self.agent in READING else None)
        return f"{self.agent}-{hashlib.sha256(reader.read_bytes()).hexdigest()[:8]}" if reader else self.agent


def main() -> None:
    """Play what was not played yet, and write the page's table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("data", type=Path, help="folder of `arramon-server import-release`")
    parser.add_argument("--split", default="val_seen")
    parser.add_argument("--lang", default="en")
    parser.add_argument("--episodes", type=int, default=40)
    parser.add_argument("--runs", type=Path, default=Path("arramon-results/people"))
    parser.add_argument("--tuned", type=Path, help="folder with a reader that was fine-tuned")
    parser.add_argument("--agents", default=",".join(AGENTS))
    parser.add_argument("--page", type=Path, default=Path("docs/results.md"))
    parser.add_argument("--play-only", action="store_true", help="do not write the page")
    given = parser.parse_args()
    split = read_split(folder_of(given.data, given.split))
    _, tested = halves(split, given.lang)
    chosen = tuple(episode.episode_id for episode in tested[: given.episodes])
    players = [Player(agent, None) for agent in given.agents.split(",")]
    if given.tuned:
        reader = given.tuned / "reader.safetensors"
        players += [Player(player.agent, reader) for player in players if player.agent in READING]
    rows = [(player, _scores(given, player, chosen)) for player in players]
    if given.play_only:
        return
    page = given.page.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    given.page.write_text(f"{before}{BEGIN}\n\n{table(rows)}\n\n{END}{rest.split(END)[1]}", encoding="utf-8")


def table(rows: Sequence[tuple[Player, Scores]]) -> str:
    """Return the table in Markdown: means with standard errors over episodes."""
    lines = [
        f"| agent | trained on | episodes | {' | '.join((*METRICS, ALONE))} |",
        f"| --- | --- | --- |{' --- |' * (len(METRICS) + 1)}",
    ]
    for player, scores in rows:
        trained = "-" if player.agent in ("random_walk", "follower") else "generated text"
        values = [_mean([each[metric] for each in scores.values()]) for metric in (*METRICS, ALONE)]
        told = f"{trained}, reader {TUNED} on people's" if player.reader else trained
        lines.append(f"| `{player.agent}` | {told} | {len(scores)} | {' | '.join(values)} |")
    return "\n".join(lines)


def _mean(values: Sequence[float]) -> str:
    average = sum(values) / len(values)
    spread = sum((value - average) ** 2 for value in values) / max(1, len(values) - 1)
    return f"{average:.3f} ± {math.sqrt(spread / len(values)):.3f}"


def _scores(given: argparse.Namespace, player: Player, chosen: tuple[str, ...]) -> Scores:
    """Return the scores of each episode by id, from the folder of runs or by playing."""
    path = given.runs / f"{player.mark}-{given.split}-{given.lang}-{len(chosen)}.json"
    if not path.exists():
        played = [
            play(
                load_agent(f"agents.{player.agent}", player.arguments),
                Plan(given.data, given.split, (given.lang,), 0, 224, phases, chosen),
            )
            for phases in (PHASES, ("assembly",))
        ]
        kept = {
            episode_id: {**{metric: scores[metric] for metric in METRICS}, ALONE: played[1][episode_id]["PTC"]}
            for episode_id, scores in played[0].items()
        }
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(kept))
        print(f"{player.mark}: done", file=sys.stderr, flush=True)
    found: Scores = json.loads(path.read_text())
    return found


if __name__ == "__main__":
    main()

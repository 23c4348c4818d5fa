"""Scores of agents on people's instructions: the table in docs/results/agents.md.

    python -m benchmarks.agents.people_agents DATA [--split S] [--lang L] [--episodes N] [--runs DIR] [--tuned DIR]
                                              [--agents A,B] [--page FILE] [--play-only]

DATA is a folder of `arramon-server import-release`. Of the split's episodes in playing order every second one may be
used for training. The agents play the first N of the others (0 for all of them), with weights that were trained on
generated text only; with `--tuned` also with the fine-tuned weights that the folder has:
`reader.safetensors` of `arramon-train --agent reader_tuning` for those that read with the learned reader, and
`AGENT.safetensors` of `arramon-train --init`. Runs in the folder of runs are reused, so that an
interrupted command can be resumed; use another folder for other data. With `--play-only` several commands can run side
by side. Placement is also played separately, after perfect navigation.
"""

import argparse
import hashlib
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arramon_agents.reading.reader.reader import WEIGHTS as READER
from arramon_agents.simulated.people_texts import halves
from arramon_agents.training.rollouts import RolloutPlan, play
from arramon_agents.weights import SHIPPED, SUFFIX, file_of
from arramon_client import load_agent
from arramon_client.world import PHASES
from arramon_server.episodes.splits import read_split, split_folder
from benchmarks.agents.results_tables import shown_difference
from benchmarks.agents.study import write_page
from benchmarks.common import markdown_table, mean_and_error, parser_of

READING = ("vl_map", "seeing_follower")
"""Agents that use the learned reader, which can be fine-tuned."""

AGENTS = ("random_walk", "language_only", "vision_only", "vl", "vl_grounded", *READING, "follower")
METRICS = ("nDTW", "CTC-3", "PTC@CTC-3")
ALONE = "PTC alone"
COLUMNS = (*METRICS, ALONE)
TUNED = "fine-tuned"
UNTRAINED = ("random_walk", "follower")
"""Agents without trained weights."""

BEGIN, END = "<!-- tables: benchmarks/agents/people_agents.py -->", "<!-- end of people's tables -->"

Scores = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class TunedAgent:
    """An agent, with the fine-tuned weights that it uses.

    Attributes:
        reader: the learned reader; None for the shipped one.
        weights: its own; None for the shipped ones.
    """

    agent: str
    reader: Path | None = None
    weights: Path | None = None

    @property
    def arguments(self) -> dict[str, object]:
        """Arguments of the agent."""
        given = {"reader": self.reader, "weights": self.weights}
        return {name: str(path) for name, path in given.items() if path}

    @property
    def run_name(self) -> str:
        """Name of its runs, which includes a hash of weights and reader."""
        shipped = file_of(SHIPPED, self.agent)
        files = [self.weights or shipped, *([self.reader or READER] if self.agent in READING else [])]
        known = b"".join(path.read_bytes() for path in files if path.exists())
        return f"{self.agent}-{hashlib.sha256(known).hexdigest()[:8]}" if known else self.agent

    @property
    def trained(self) -> str:
        """Kind of text that it was trained on, as shown in the table."""
        if self.agent in UNTRAINED:
            return "-"
        what = [name for name, path in (("reader", self.reader), ("agent", self.weights)) if path]
        return f"generated text, {' and '.join(what)} {TUNED} on people's" if what else "generated text"


def setups_of(agents: Sequence[str], tuned: Path | None) -> list[TunedAgent]:
    """Return each agent as shipped, and again with the fine-tuned weights that a folder has for it."""
    setups = []
    for agent in agents:
        setups.append(TunedAgent(agent))
        reader = tuned / f"reader{SUFFIX}" if tuned and agent in READING else None
        weights = tuned / f"{agent}{SUFFIX}" if tuned else None
        found = [path if path and path.exists() else None for path in (reader, weights)]
        if any(found):
            setups.append(TunedAgent(agent, *found))
    return setups


def main() -> None:
    """Play the missing runs, and write the page's table."""
    parser = parser_of(__doc__)
    parser.add_argument("data", type=Path, help="folder of `arramon-server import-release`")
    parser.add_argument("--split", default="val_seen")
    parser.add_argument("--lang", default="en")
    parser.add_argument("--episodes", type=int, default=64, help="of the half to test on; 0 for all of it")
    parser.add_argument("--runs", type=Path, default=Path("arramon-results/people"))
    parser.add_argument("--tuned", type=Path, help="folder with what was fine-tuned")
    parser.add_argument("--agents", default=",".join(AGENTS))
    parser.add_argument("--page", type=Path, default=Path("docs/results/agents.md"))
    parser.add_argument("--play-only", action="store_true", help="do not write the page")
    given = parser.parse_args()
    split = read_split(split_folder(given.data, given.split))
    _, tested = halves(split, given.lang)
    chosen = tuple(episode.episode_id for episode in tested[: given.episodes or None])
    rows = [(setup, _scores(given, setup, chosen)) for setup in setups_of(given.agents.split(","), given.tuned)]
    if not given.play_only:
        write_page(given.page, BEGIN, END, "\n\n".join(filter(None, (table(rows), tuned_table(rows)))))


def table(rows: Sequence[tuple[TunedAgent, Scores]]) -> str:
    """Return the table in Markdown: means with standard errors over episodes."""
    lines = [
        [
            f"`{setup.agent}`",
            setup.trained,
            str(len(scores)),
            *(_mean([each[metric] for each in scores.values()]) for metric in COLUMNS),
        ]
        for setup, scores in rows
    ]
    return markdown_table(["agent", "trained on", "episodes", *COLUMNS], lines)


def tuned_table(rows: Sequence[tuple[TunedAgent, Scores]]) -> str:
    """Return the effect of fine-tuning, paired by episode, with 95% intervals; empty without fine-tuned weights."""
    plain = {setup.agent: scores for setup, scores in rows if setup == TunedAgent(setup.agent)}
    lines = []
    for setup, scores in rows:
        if setup.arguments and setup.agent in plain:
            common = sorted(scores.keys() & plain[setup.agent].keys())
            pairs = [
                [np.array([each[name][metric] for name in common]) for each in (scores, plain[setup.agent])]
                for metric in COLUMNS
            ]
            lines.append([f"`{setup.agent}`", *(shown_difference(*pair) for pair in pairs)])
    return "Effects of fine-tuning:\n\n" + markdown_table(["agent", *COLUMNS], lines) if lines else ""


def _mean(values: Sequence[float]) -> str:
    average, error = mean_and_error(values)
    return f"{average:.3f} ± {error:.3f}"


def _scores(given: argparse.Namespace, setup: TunedAgent, chosen: tuple[str, ...]) -> Scores:
    """Return the scores of each episode by id, from the folder of runs or by playing."""
    path = given.runs / f"{setup.run_name}-{given.split}-{given.lang}-{len(chosen)}.json"
    if not path.exists():
        played = [
            play(
                load_agent(f"agents.{setup.agent}", setup.arguments),
                RolloutPlan(given.data, given.split, (given.lang,), 0, phases=phases, chosen=chosen),
            )
            for phases in (PHASES, ("assembly",))
        ]
        kept = {
            episode_id: {**{metric: scores[metric] for metric in METRICS}, ALONE: played[1][episode_id]["PTC"]}
            for episode_id, scores in played[0].items()
        }
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(kept))
        print(f"{setup.run_name}: done", file=sys.stderr, flush=True)
    found: Scores = json.loads(path.read_text())
    return found


if __name__ == "__main__":
    main()

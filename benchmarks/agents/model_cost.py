"""Calls and tokens of an episode with `agents.vlm`, by length of plans and window, measured with a fake endpoint.

    python -m benchmarks.agents.model_cost [--data DIR] [--split S] [--plans N,N] [--windows N,N] [--episodes N]

The endpoint answers with the actions of the ground truth, so a model that looks around takes more. It counts a token
for every 4 characters, and 85 for a frame (benchmarks/agents/fake_endpoint.py). Each row is a run of the real client
with an embedded server. Prints the mean calls and tokens of an episode, and how much of what was read could be cached:
the system prompt with the instruction stays the same during a phase.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from arramon_client.world import PHASES
from arramon_server.episodes.splits import Split, read_splits
from benchmarks.agents.fake_endpoint import Expert, FakeEndpoint
from benchmarks.common import data_or_sample, largest_split, markdown_table, parser_of, positive_int

KEY_VARIABLE = "FAKE_ENDPOINT_KEY"


def main() -> None:
    """Play a run for each setting, and print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("--data", type=Path, metavar="DIR", help="data folder (default: the sample episodes)")
    parser.add_argument("--split", help="split of the data folder (default: the largest)")
    parser.add_argument("--lang", default="en")
    parser.add_argument("--plans", default="1,2,4,8", help="lengths of plans (default: %(default)s)")
    parser.add_argument("--windows", default="0,4,16", help="windows (default: %(default)s)")
    parser.add_argument("--episodes", type=positive_int, default=10, help="of each run (default: %(default)s)")
    parser.add_argument("--words", action="store_true", help="words in place of frames")
    given = parser.parse_args()
    with data_or_sample(given.data) as data:
        splits = read_splits(data)
        split = splits[given.split] if given.split else largest_split(data)
        actions = actions_of(split, given.lang)
        rows = [
            row_of(measure(data, split.name, actions, plan, window, given), plan, window)
            for plan in map(int, given.plans.split(","))
            for window in map(int, given.windows.split(","))
        ]
    header = ("plan", "window", "episodes", "steps", "calls", "tokens read", "cached", "tokens written")
    print(markdown_table(header, rows))


def actions_of(split: Split, language: str) -> dict[str, Sequence[int]]:
    """Return the ground truth of each phase, by its instruction.

    Of episodes whose instructions are alike, the last one's count.
    """
    found: dict[str, Sequence[int]] = {}
    for episode in split.episodes.values():
        if language not in episode.instructions:
            continue
        for number, turn in enumerate(episode.turns, 1):
            for phase, actions in zip(PHASES, (turn.actions, turn.room_actions), strict=True):
                found[episode.instruction(language, number, phase)] = [int(action) for action in actions]
    return found


def measure(
    data: Path, split: str, actions: Mapping[str, Sequence[int]], plan: int, window: int, given: argparse.Namespace
) -> dict[str, Any]:
    """Return the results file of a run.

    Raises:
        SystemExit: if the client fails; its message is printed.
    """
    client = str(Path(sys.executable).with_name("arramon-client"))
    with tempfile.TemporaryDirectory() as folder, FakeEndpoint(Expert(actions, plan)) as endpoint:
        arguments = {
            "model": "fake", "endpoint": endpoint.url, "key_variable": KEY_VARIABLE, "plan": plan, "window": window,
            "trace": folder, "images": "false" if given.words else "true", "sight": "skip",
        }  # fmt: skip
        command = [
            client, "--agent", "agents.vlm", "--lang", given.lang, "--data", str(data), "--split", split, "--quiet",
            "--episodes", str(given.episodes), "--output", folder, "--json",
            *(word for name, value in arguments.items() for word in ("--agent-arg", f"{name}={value}")),
        ]  # fmt: skip
        done = subprocess.run(
            command, env={**os.environ, KEY_VARIABLE: "fake"}, capture_output=True, text=True, check=False
        )
    if done.returncode:
        sys.exit(f"the client ended with status {done.returncode}:\n{done.stderr}")
    content: dict[str, Any] = json.loads(done.stdout)
    return content


def row_of(content: Mapping[str, Any], plan: int, window: int) -> tuple[str, ...]:
    """Return the row of a run: means over its episodes."""
    episodes = len(content["episodes"])
    measured = content["agent_report"]["measured"]
    tokens = measured["tokens"]
    numbers = (
        content["run"]["steps"] / episodes,
        measured["calls"] / episodes,
        tokens["prompt"] / episodes,
        tokens["cached"] / episodes,
        tokens["completion"] / episodes,
    )
    return (str(plan), str(window), str(episodes), *(f"{number:,.0f}" for number in numbers))


if __name__ == "__main__":
    main()

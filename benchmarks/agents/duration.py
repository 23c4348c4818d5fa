"""Playing speed of agents: steps per second of clients that play at the same time.

    python -m benchmarks.agents.duration [--data DIR] [--split S] [--agents A,B] [--episodes N] [--parallel K]

Each agent plays the first N episodes in each language at once, by a client and an embedded server of its own, as users
run it. Prints its steps a second, those of all its clients together, the ratio to the first agent, and how many minutes
1,155 episodes (the size of the paper's hidden split) take at that rate without the start. The machine should be idle.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.common import markdown_table, parser_of

LANGUAGES = ("en", "hi")
HIDDEN_SPLIT_EPISODES = 1155
"""Episodes of the paper's hidden split."""

REPORT = re.compile(r"(\d+) steps in ([\d.]+) s")
"""The client's message at the end of a run."""


def main() -> None:
    """Play, and print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("--data", type=Path, default=Path("arramon-data"))
    parser.add_argument("--split", default="val_seen")
    parser.add_argument("--agents", default="follower,vl,vl_map", help="the first one is the baseline")
    parser.add_argument("--episodes", type=int, default=69, help="of each client")
    parser.add_argument("--parallel", type=int, default=8)
    given = parser.parse_args()
    rows, baseline = [], 0.0
    for agent in given.agents.split(","):
        seconds, steps, start = play(agent, given)
        rate = steps / seconds
        baseline = baseline or rate
        minutes = HIDDEN_SPLIT_EPISODES / (len(LANGUAGES) * given.episodes) * seconds / 60
        rows.append((f"`{agent}`", f"{rate:.0f}", f"{rate / baseline:.2f}", f"{start:.0f}", f"{minutes:.1f}"))
    print(markdown_table(("agent", "steps/s", "ratio", "start, s", "minutes for 1,155"), rows))


def play(agent: str, given: argparse.Namespace) -> tuple[float, int, float]:
    """Return the seconds of the slowest client without its start, the steps of all, and the seconds of the start."""
    client = str(Path(sys.executable).with_name("arramon-client"))
    with tempfile.TemporaryDirectory() as folder:
        began = time.monotonic()
        clients = [
            subprocess.Popen(
                [
                    client, "--agent", f"agents.{agent}", "--lang", language, "--split", given.split,
                    "--data", str(given.data), "--episodes", str(given.episodes), "--parallel", str(given.parallel),
                    "--output", f"{folder}/{language}", "--quiet",
                ],
                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
            )
            for language in LANGUAGES
        ]  # fmt: skip
        said = [each.communicate()[1] for each in clients]
        whole = time.monotonic() - began
    found = [REPORT.search(text) for text in said]
    if any(each.returncode for each in clients) or None in found:
        sys.exit(f"{agent} did not finish its run:\n" + "\n".join(said))
    reports = [(int(match[1]), float(match[2])) for match in found if match]
    seconds = max(each for _, each in reports)
    return seconds, sum(steps for steps, _ in reports), whole - seconds


if __name__ == "__main__":
    main()

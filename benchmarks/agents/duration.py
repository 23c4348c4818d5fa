"""Playing speed of agents: steps per second of clients that play at the same time.

    python -m benchmarks.agents.duration [--data DIR] [--split S] [--agents A,B] [--languages en] [--episodes N]
        [--parallel K] [--client PATH]

Each agent plays the first N episodes in each language at once, by a client and an embedded server of its own, as users
run it. Prints its steps a second, those of all its clients together, the ratio to the first agent, how many minutes
1,155 episodes (the size of the paper's hidden split) take at that rate without the start, and the CPU time of clients
and servers, with their start. The machine should be idle; CPU time can be compared on a busy machine, too, with that of
another version, whose client `--client` names.
"""

import argparse
import re
import resource
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
    parser.add_argument("--languages", default=",".join(LANGUAGES), help="one client for each")
    parser.add_argument("--client", type=Path, default=Path(sys.executable).with_name("arramon-client"))
    given = parser.parse_args()
    languages = given.languages.split(",")
    rows, baseline = [], 0.0
    for agent in given.agents.split(","):
        before = cpu_seconds()
        seconds, steps, start = play(agent, languages, given)
        cpu = (cpu_seconds() - before) / (len(languages) * given.episodes)
        rate = steps / seconds
        baseline = baseline or rate
        minutes = HIDDEN_SPLIT_EPISODES / (len(languages) * given.episodes) * seconds / 60
        rows.append(
            (f"`{agent}`", f"{rate:.0f}", f"{rate / baseline:.2f}", f"{start:.0f}", f"{minutes:.1f}", f"{cpu:.2f}")
        )
    print(markdown_table(("agent", "steps/s", "ratio", "start, s", "minutes for 1,155", "CPU s per episode"), rows))


def cpu_seconds() -> float:
    """Return the CPU time of all child processes that have ended, and of theirs, in seconds."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def play(agent: str, languages: list[str], given: argparse.Namespace) -> tuple[float, int, float]:
    """Return the seconds of the slowest client without its start, the steps of all, and the seconds of the start."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.monotonic()
        clients = [
            subprocess.Popen(
                [
                    str(given.client), "--agent", f"agents.{agent}", "--lang", language, "--split", given.split,
                    "--data", str(given.data), "--episodes", str(given.episodes), "--parallel", str(given.parallel),
                    "--output", f"{folder}/{language}", "--quiet",
                ],
                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
            )
            for language in languages
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

"""What went well in a run, and what did not: python examples/analyse_run.py arramon-results/RUN.json

It reads the file that `arramon-client` writes after a run of an open split, and nothing else.
"""

import json
import sys
from collections import Counter
from pathlib import Path
from typing import Any

OUTCOMES = (
    "placed exactly",
    "right object, placed wrongly",
    "near the target, without it",
    "never near the target",
)


def outcome(scores: dict[str, float]) -> str:
    """Return how a turn ended, from its scores: PTC is placement, CTC-0 the pick-up, CTC-3 the end of the walk."""
    if scores["CTC-0"] and scores["PTC"]:
        return OUTCOMES[0]
    if scores["CTC-0"]:
        return OUTCOMES[1]
    return OUTCOMES[2] if scores["CTC-3"] else OUTCOMES[3]


def report(results: dict[str, Any], worst: int = 5) -> list[str]:
    """Return lines: scores with their intervals, turns by outcome, episodes by cause, and the worst episodes."""
    run, episodes = results["run"], results["episodes"]
    lines = [f"{run['agent']} on {run['split']}, {run['language']}: {len(episodes)} episodes", ""]
    for metric in ("nDTW", "CTC-3", "rPOD@CTC-3", "PTC@CTC-3"):
        score = results["metrics"]["total"][metric]
        lines.append(f"{metric:11} {score['mean']:.3f}  95% interval {score['low']:.3f} to {score['high']:.3f}")
    for number in (1, 2):
        counts = Counter(outcome(each["turns"][f"turn {number}"]) for each in episodes)
        lines += ["", f"turn {number}:", *(f"  {counts[name]:4} {name}" for name in OUTCOMES)]
    lines += ["", "episodes by cause:"]
    lines += [f"  {count:4} {cause}" for cause, count in Counter(each["cause"] for each in episodes).most_common()]
    lines += ["", "lowest nDTW, to be watched first:"]
    lines += [f"  {each['episode_id']}: {mean(each):.3f}" for each in sorted(episodes, key=mean)[:worst]]
    return lines


def mean(episode: dict[str, Any]) -> float:
    """Return an episode's nDTW, the mean over its turns."""
    return float(sum(turn["nDTW"] for turn in episode["turns"].values()) / len(episode["turns"]))


if __name__ == "__main__":
    print("\n".join(report(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")))))

"""Scores of runs with their 95% intervals, as a chart: python examples/plot_scores.py chart.svg RUN.json [RUN.json ...]

It reads the files that `arramon-client` writes after a run, and needs `pip install matplotlib`.
"""

import json
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("agg")
from matplotlib import pyplot as plt

METRICS = ("nDTW", "CTC-3", "PTC@CTC-3")

Results = dict[str, Any]


def label(results: Results) -> str:
    """Return the name of a run in the chart."""
    run = results["run"]
    return f"{run['agent']}, {run['language']}"


def draw(runs: list[Results], target: Path) -> None:
    """Draw a panel for each metric, with a row for each run."""
    figure, axes = plt.subplots(1, len(METRICS), sharey=True, figsize=(9, 1.2 + 0.35 * len(runs)))
    for axis, metric in zip(axes, METRICS, strict=True):
        for row, results in enumerate(runs):
            score = results["metrics"]["total"][metric]
            axis.plot([score["low"], score["high"]], [row, row], color="#0072b2", linewidth=2)
            axis.plot(score["mean"], row, "o", color="#0072b2")
        axis.set_title(metric)
        axis.set_xlim(0, 1)
        axis.grid(axis="x", alpha=0.4)
    axes[0].set_yticks(range(len(runs)), [label(results) for results in runs])
    axes[0].set_ylim(len(runs) - 0.5, -0.5)
    figure.tight_layout()
    figure.savefig(target)
    plt.close(figure)


if __name__ == "__main__":
    draw([json.loads(Path(name).read_text(encoding="utf-8")) for name in sys.argv[2:]], Path(sys.argv[1]))

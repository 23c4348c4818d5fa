"""Charts of the agents' scores beside the paper's, with 95% intervals: from the tables of `docs/results/agents.md`."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from website.figures import style
from website.figures.tables import read_tables
from website.staging import DOCS

PAGE = DOCS / "results" / "agents.md"

METRICS = {"nDTW": "results-ndtw", "CTC-3": "results-ctc-3", "PTC alone": "results-placement"}
"""Names of the charts, by metric."""

SPLITS = ("val_seen", "val_unseen")

NORMAL = 1.96
"""Half the width of a 95% interval, in standard errors."""

PAPER = "the paper's "


def rows(metric: str) -> list[dict[str, Any]]:
    """Return the data of a chart: split, agent, language, seeds, episodes, score, and the bounds of its interval.

    The standard error of a mean over S seeds and N episodes is computed from the standard deviations in the table of
    seeds: between seeds, between episodes, and the rest. Agents with one seed are not in it, and have no interval.
    """
    made = []
    for split in SPLITS:
        scores, *_, seeds = read_tables(PAGE, split)
        spread = {(row["agent"], row["language"]): row for row in seeds if row["metric"] == metric}
        for row in scores:
            if not row[metric]:
                continue
            agent, language = (
                row["agent"].strip("*`").partition(": other data")[0].replace("`", ""),
                row["language"].strip("*"),
            )
            score = float(row[metric])
            half = _half(spread.get((row["agent"], row["language"])), row["seeds"], row["episodes"])
            made.append({
                "split": split, "agent": agent, "language": language, "seeds": row["seeds"],
                "episodes": row["episodes"],
                "score": row[metric],
                "low": "" if half is None else f"{max(0.0, score - half):.3f}",
                "high": "" if half is None else f"{min(1.0, score + half):.3f}",
            })  # fmt: skip
    return made


def intervals(split: str) -> str:
    """Return a table of the means of a split with their intervals, of the agents with several seeds."""
    cells: dict[tuple[str, str], list[str]] = {}
    for metric in METRICS:
        for row in rows(metric):
            if row["split"] == split and row["low"]:
                low, high = (bound.removeprefix("0") for bound in (row["low"], row["high"]))
                cells.setdefault((row["agent"], row["language"]), []).append(f"{row['score']} ({low} to {high})")
    head = ("agent", "language", *METRICS)
    lines = [head, ["---"] * len(head), *([f"`{agent}`", language, *its] for (agent, language), its in cells.items())]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _half(spread: Mapping[str, str] | None, seeds: str, episodes: str) -> float | None:
    if spread is None:
        return None
    count, size = int(seeds), int(episodes)
    seed, episode, rest = (float(spread[name]) for name in ("between seeds", "between episodes", "rest"))
    return NORMAL * math.sqrt(seed**2 / count + episode**2 / size + rest**2 / (count * size))


def draw(metric: str, target: Path) -> None:
    """Draw the chart of a metric."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot as plt

    data = rows(metric)
    agents = list(dict.fromkeys(row["agent"] for row in data))
    with mpl.rc_context(style.settings()):
        figure, axes = plt.subplots(1, 2, sharey=True, figsize=(9.2, 0.9 + 0.27 * len(agents)))
        for axis, split in zip(axes, SPLITS, strict=True):
            _panel(axis, [row for row in data if row["split"] == split], agents)
            axis.set_title(split, loc="left")
            axis.set_xlabel(metric, color=style.SOFT)
        handles, labels = axes[0].get_legend_handles_labels()
        unique = dict(zip(labels, handles, strict=True))
        figure.legend(unique.values(), unique.keys(), loc="upper left", ncols=4, frameon=False, labelcolor=style.INK)
        figure.tight_layout(rect=(0, 0, 1, 0.96), w_pad=2.5)
        style.save(figure, data, target)
        plt.close(figure)


def _panel(axis: Any, data: Sequence[Mapping[str, Any]], agents: Sequence[str]) -> None:
    axis.set_yticks(range(len(agents)), [name.replace(" sensor=segmentation", " + labels") for name in agents])
    axis.set_ylim(len(agents) - 0.4, -0.6)
    axis.set_xlim(-0.02, 1.02)
    axis.grid(axis="x")
    axis.tick_params(length=0)
    for row in data:
        is_paper = row["agent"].startswith(PAPER)
        colour, marker, shift, label = {
            "en": (style.FIRST, "o", -0.14, "English"), "hi": (style.SECOND, "s", 0.14, "Hindi"),
            "any": (style.THIRD, "^", 0.0, "no language"),
        }[row["language"]]  # fmt: skip
        if is_paper:
            colour, marker, shift, label = style.SOFT, "D", 0.0, "the paper, other data"
        at, score = agents.index(row["agent"]) + shift, float(row["score"])
        if row["low"]:
            axis.plot([float(row["low"]), float(row["high"])], [at, at], color=colour, linewidth=1.8)
        axis.plot(
            score,
            at,
            marker,
            color=colour,
            markersize=4.5,
            label=label,
            markerfacecolor=colour if row["low"] else "none",
        )

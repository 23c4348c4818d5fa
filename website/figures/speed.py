"""The chart of the simulator's speed beside that of other projects: from the tables of `docs/results/benchmarks.md`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from website.figures import style
from website.figures.tables import Row, table
from website.staging import DOCS

PAGE = DOCS / "results" / "benchmarks.md"

NAME = "speed-peers"

PEERS = ("tiny", "ViZDoom", "MiniWorld", "MiniGrid")
"""Beginnings of the names of other projects' rows."""

FRAMES, STEPS = "frames per second of a camera", "steps per second of an environment"
"""Titles of the panels."""

BUSY = " (on a busy machine)"
"""Ending of the names of rows that were measured on a busy machine."""

BASELINE = "camera and rules"
"""Rows of the second table that are no environment begin so, or are the same in another order."""


def rows() -> list[dict[str, Any]]:
    """Return the data of the chart: what is measured, by whom, whether on a busy machine, and the rate per second."""
    cameras = table(PAGE, "How fast is a frame?", "camera")
    environments = table(PAGE, "How fast is a step in an environment?", "")
    return [
        *(_row(FRAMES, f"{row['camera']}, {row['size']}", row["frames/s"]) for row in cameras),
        *(
            _row(STEPS, row[""], row["steps/s"])
            for row in environments
            if not row[""].startswith((BASELINE, "the same"))
        ),
    ]


def _row(measure: str, name: str, rate: str) -> dict[str, Any]:
    plain, busy, _ = name.replace("*", "").replace("`", "").partition(BUSY)
    return {
        "measure": measure, "name": plain, "project": "other" if plain.startswith(PEERS) else "ArraMon",
        "machine": "busy" if busy else "", "per second": rate.strip("*"),
    }  # fmt: skip


def draw(target: Path) -> None:
    """Draw the chart."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot as plt

    data = rows()
    panels = {title: [row for row in data if row["measure"] == title] for title in (FRAMES, STEPS)}
    sizes = [len(its) for its in panels.values()]
    with mpl.rc_context(style.settings()):
        figure, axes = plt.subplots(2, 1, sharex=True, figsize=(8.2, 1.4 + 0.3 * len(data)), height_ratios=sizes)
        for axis, (title, its) in zip(axes, panels.items(), strict=True):
            _panel(axis, its)
            axis.set_title(title, loc="left")
        axes[1].set_xlabel("per second; each grid line is ten times the one before", color=style.SOFT)
        unique = {label: mark for axis in axes for mark, label in zip(*axis.get_legend_handles_labels(), strict=True)}
        figure.legend(unique.values(), unique.keys(), loc="upper right", ncols=3, frameon=False, labelcolor=style.INK)
        figure.tight_layout(rect=(0, 0, 1, 0.96))
        style.save(figure, data, target)
        plt.close(figure)


def _panel(axis: Any, data: Sequence[Row]) -> None:
    axis.set_yticks(range(len(data)), [row["name"] for row in data])
    axis.set_ylim(len(data) - 0.5, -0.5)
    axis.set_xscale("log")
    axis.set_xlim(20, 60000)
    axis.set_xticks([100, 1000, 10000], ["100", "1,000", "10,000"])
    axis.minorticks_off()
    axis.grid(axis="x")
    axis.tick_params(length=0)
    for at, row in enumerate(data):
        ours, busy, rate = row["project"] == "ArraMon", bool(row["machine"]), float(row["per second"])
        colour, marker = (style.FIRST, "o") if ours else (style.SECOND, "s")
        label = "ArraMon" if ours else "another project, busy machine" if busy else "another project"
        axis.plot(
            rate, at, marker, color=colour, markersize=5.5, markerfacecolor="none" if busy else colour, label=label
        )
        axis.annotate(
            f"{rate:,.0f}", (rate, at), xytext=(8, 0), textcoords="offset points", va="center", color=style.INK,
        )  # fmt: skip

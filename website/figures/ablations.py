"""Charts of ablations as differences with their 95% intervals: from the tables of `docs/results/ablations.md`."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from website.figures import style
from website.figures.tables import difference, read_tables
from website.staging import DOCS

PAGE = DOCS / "results" / "ablations.md"

CHARTS = {
    f"ablations-{name}-{split}": f"{split}: `{agent}`, {rest}"
    for split in ("val_seen", "val_unseen")
    for name, agent, rest in (
        ("vl", "vl", "all trained for the same CPU time"), ("vl-map", "vl_map", "with something left out at play"),
    )
}  # fmt: skip
"""Sections of the page, by the names of their charts."""


def rows(name: str) -> list[dict[str, Any]]:
    """Return the data of a chart: variation, meaning, language, metric, difference, bounds of its interval."""
    made = []
    for row in read_tables(PAGE, CHARTS[name])[0]:
        cells = list(row.items())
        for (metric, _), (_, cell) in zip(cells[3::2], cells[4::2], strict=True):
            if found := difference(cell):
                made.append({
                    "variation": cells[0][1].strip("`"), "meaning": cells[1][1], "language": row["language"],
                    "metric": metric,
                    "difference": f"{found[0]:+.3f}", "low": f"{found[1]:+.3f}", "high": f"{found[2]:+.3f}",
                })  # fmt: skip
    return made


def draw(name: str, target: Path) -> None:
    """Draw a chart."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot as plt

    data = rows(name)
    names = list(dict.fromkeys(row["variation"] for row in data))
    metrics = list(dict.fromkeys(row["metric"] for row in data))
    with mpl.rc_context(style.settings()):
        figure, axes = plt.subplots(1, len(metrics), sharey=True, figsize=(9.2, 1.1 + 0.33 * len(names)), squeeze=False)
        for axis, metric in zip(axes[0], metrics, strict=True):
            _panel(axis, [row for row in data if row["metric"] == metric], names)
            axis.set_title(metric, loc="left")
        handles, labels = axes[0][0].get_legend_handles_labels()
        unique = dict(zip(labels, handles, strict=True))
        figure.legend(unique.values(), unique.keys(), loc="upper right", ncols=2, frameon=False, labelcolor=style.INK)
        figure.supxlabel(
            "difference, with its 95% interval; filled if the interval excludes 0", color=style.SOFT, fontsize=9
        )
        figure.tight_layout(rect=(0, 0, 1, 0.96))
        style.save(figure, data, target)
        plt.close(figure)


def _panel(axis: Any, data: Sequence[Mapping[str, Any]], names: Sequence[str]) -> None:
    axis.axvline(0, color=style.SOFT, linewidth=0.8)
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(len(names) - 0.4, -0.6)
    axis.grid(axis="x")
    axis.tick_params(length=0)
    for row in data:
        colour, marker, shift, label = {
            "en": (style.FIRST, "o", -0.15, "English"), "hi": (style.SECOND, "s", 0.15, "Hindi"),
        }[row["language"]]  # fmt: skip
        at, low, high = names.index(row["variation"]) + shift, float(row["low"]), float(row["high"])
        axis.plot([low, high], [at, at], color=colour, linewidth=1.8)
        fill = colour if low > 0 or high < 0 else "none"
        axis.plot(float(row["difference"]), at, marker, color=colour, markersize=4.5, markerfacecolor=fill, label=label)

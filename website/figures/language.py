"""Charts of the texts' phrases beside people's: from the tables of `docs/explanation/data.md`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from website.figures import style
from website.figures.tables import Row, table
from website.staging import DOCS

PAGE = DOCS / "explanation" / "data.md"

SERIES = {
    "people": ("people’s, in English", "D", style.THIRD, 0.0),
    "en": ("generated, English", "o", style.FIRST, -0.14),
    "hi": ("generated, Hindi", "s", style.SECOND, 0.14),
}
"""Label, mark, colour and offset of each series."""

ASSEMBLY = "assembly"


@dataclass(frozen=True)
class Chart:
    """A chart of shares.

    Attributes:
        section: heading of the table's section.
        first: heading of the table's first column, with the phrases.
        columns: heading of each series' column.
    """

    section: str
    first: str
    columns: Mapping[str, str]


CHARTS = {
    "language-phrases": Chart(
        "How near the texts are to people's", "share of English texts", {"en": "now", "people": "people"}
    ),
    "language-paths": Chart(
        "Statistics",
        "share of navigation instructions that name",
        {"en": "en", "hi": "hi", "people": "release"},
    ),
}


def rows(name: str) -> list[dict[str, Any]]:
    """Return the data of a chart: phase, phrase, series, share in percent. Rows of other figures are left out."""
    chart, made, phase = CHARTS[name], [], "navigation"
    for row in table(PAGE, chart.section, chart.first):
        before, colon, phrase = row[chart.first].partition(": ")
        phase = before if colon else phase
        for series, column in chart.columns.items():
            if row[column].endswith("%"):
                made.append({
                    "phase": phase, "phrase": phrase if colon else before, "texts": series,
                    "percent": row[column].rstrip("%"),
                })  # fmt: skip
    return made


def draw(name: str, target: Path) -> None:
    """Draw a chart."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot as plt

    data = rows(name)
    panels = {phase: [row for row in data if row["phase"] == phase] for phase in _names(data, "phase")}
    sizes = [len(_names(its, "phrase")) for its in panels.values()]
    with mpl.rc_context(style.settings()):
        figure, axes = plt.subplots(
            len(panels), 1, sharex=True, squeeze=False, figsize=(8.2, 1.2 + 0.28 * sum(sizes) + 0.4 * len(sizes)),
            height_ratios=sizes,
        )  # fmt: skip
        for axis, (phase, its) in zip(axes[:, 0], panels.items(), strict=True):
            _panel(axis, its)
            axis.set_title(phase, loc="left")
        axes[-1, 0].set_xlabel("share of texts, %", color=style.SOFT)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        unique = dict(zip(labels, handles, strict=True))
        figure.legend(unique.values(), unique.keys(), loc="upper right", ncols=3, frameon=False, labelcolor=style.INK)
        figure.tight_layout(rect=(0, 0, 1, 0.97))
        style.save(figure, data, target)
        plt.close(figure)


def _panel(axis: Any, data: Sequence[Row]) -> None:
    phrases = _names(data, "phrase")
    axis.set_yticks(range(len(phrases)), phrases)
    axis.set_ylim(len(phrases) - 0.5, -0.5)
    axis.grid(axis="x")
    axis.tick_params(length=0)
    for at, phrase in enumerate(phrases):
        shares = [float(row["percent"]) for row in data if row["phrase"] == phrase]
        axis.plot([min(shares), max(shares)], [at, at], color=style.LINE, linewidth=2.5, zorder=1)
    for series, (label, marker, colour, shift) in SERIES.items():
        its = [row for row in data if row["texts"] == series]
        if its:
            axis.plot(
                [float(row["percent"]) for row in its], [phrases.index(row["phrase"]) + shift for row in its],
                marker, color=colour, markersize=5, label=label, zorder=2,
            )  # fmt: skip
    axis.set_xlim(left=-1)


def _names(data: Sequence[Row], column: str) -> list[str]:
    return list(dict.fromkeys(row[column] for row in data))

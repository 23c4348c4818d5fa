"""The look of the charts, and their files: an SVG that follows light and dark, and a CSV with its data.

Charts are drawn with stand-ins for colours, which the file names as variables with a value for light and one for dark.
An image follows the colour scheme of the page that shows it, or of the system.
"""

import csv
import hashlib
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

INK, SOFT, LINE, FIRST, SECOND, THIRD = "#010101", "#020202", "#030303", "#040404", "#050505", "#060606"
"""Stand-ins: text, minor text, grid lines, and the colours of series (blue, orange and green of Okabe and Ito)."""

VARIABLES = {INK: "ink", SOFT: "soft", LINE: "line", FIRST: "first", SECOND: "second", THIRD: "third"}

COLOURS = """\
<style>
:root { --ink: #1b2027; --soft: #55606c; --line: #d3d9e0; --first: #0072b2; --second: #d55e00; --third: #00795a;
  --fill: #eef1f4 }
@media (prefers-color-scheme: dark) {
:root { --ink: #e7eaee; --soft: #a7b1bc; --line: #3a444e; --first: #6cbcf0; --second: #ff9d5c; --third: #46c795;
  --fill: #222930 }
}
</style>
"""

VERSION = 1
"""Grows when charts of the same data are to be drawn anew."""

Rows = Sequence[Mapping[str, Any]]


def as_csv(rows: Rows) -> str:
    """Return rows as CSV, with a head."""
    out = io.StringIO()
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def stamp(data: str) -> str:
    """Return the comment that names the data of a chart, by which a test finds out whether it is up to date."""
    return f"<!-- data {hashlib.sha256(data.encode()).hexdigest()[:16]}, look {VERSION} -->"


def save(figure: Any, rows: Rows, target: Path) -> None:
    """Write a chart of matplotlib and its data.

    Args:
        figure: drawn with the stand-ins.
        rows: its data.
        target: path of the SVG; the CSV lies beside it.
    """
    out = io.StringIO()
    figure.savefig(out, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    for stand_in, name in VARIABLES.items():
        text = text.replace(stand_in, f"var(--{name})")
    opening, rest = text.partition("<svg")[2].split(">", 1)
    data = as_csv(rows)
    svg = f"<svg{opening}>\n{stamp(data)}\n{COLOURS}{rest}"
    target.write_text("\n".join(line.rstrip() for line in svg.split("\n")), encoding="utf-8")
    target.with_suffix(".csv").write_text(data, encoding="utf-8")


def settings() -> dict[str, Any]:
    """Return matplotlib's settings: texts stay texts, in the reader's own font."""
    return {
        "svg.fonttype": "none",
        "svg.hashsalt": "arramon",
        "font.family": "sans-serif",
        "font.sans-serif": ["DejaVu Sans"],
        "font.size": 9,
        "text.color": INK,
        "axes.labelcolor": INK,
        "axes.edgecolor": LINE,
        "axes.titlesize": 10,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.spines.left": False,
        "xtick.color": LINE,
        "xtick.labelcolor": SOFT,
        "ytick.color": LINE,
        "ytick.labelcolor": INK,
        "grid.color": LINE,
        "grid.linewidth": 0.6,
    }

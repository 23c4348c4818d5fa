"""The learning curve of the shipped reader: from the table of its model card."""

from pathlib import Path
from typing import Any

from website.figures import style
from website.figures.tables import table
from website.staging import DOCS

PAGE = DOCS.parent / "agents" / "reading" / "reader" / "card.md"

NAME = "learning-reader"

LANGUAGES = {"English": style.FIRST, "Hindi": style.SECOND}
"""Languages with the colours of their curves."""

SHARES = {"rows": "o-", "texts": "s--"}
"""Columns of a language, with the style of their curves: rows, and whole texts, that are read exactly right."""


def rows() -> list[dict[str, Any]]:
    """Return the data of the chart: updates so far, loss, and shares that are read exactly right."""
    return [dict(row) for row in table(PAGE, "Learning curve", "updates")]


def draw(target: Path) -> None:
    """Draw the chart."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot as plt

    data = rows()
    updates = [int(row["updates"]) for row in data]
    with mpl.rc_context(style.settings()):
        figure, (loss, shares) = plt.subplots(2, 1, sharex=True, figsize=(8.2, 4.6), height_ratios=(1, 1.6))
        loss.plot(updates, [float(row["loss"]) for row in data], "o-", color=style.THIRD, markersize=4)
        loss.set_title("loss, mean since the point before", loc="left")
        loss.set_ylim(bottom=0)
        for language, colour in LANGUAGES.items():
            for share, look in SHARES.items():
                values = [float(row[f"{language}, {share}"]) for row in data]
                shares.plot(updates, values, look, color=colour, markersize=4, label=f"{language}, {share}")
        shares.set_title("share read exactly right, of the texts of held-out episodes", loc="left")
        shares.set_ylim(0, 1)
        shares.set_xlabel("updates", color=style.SOFT)
        shares.legend(frameon=False, labelcolor=style.INK, loc="lower right")
        for axis in (loss, shares):
            axis.grid(axis="y")
            axis.tick_params(length=0)
        figure.tight_layout()
        style.save(figure, data, target)
        plt.close(figure)

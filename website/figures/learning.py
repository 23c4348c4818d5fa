"""The learning curves of the shipped reader and of `vl_map`: from the tables of their model cards."""

from pathlib import Path
from typing import Any

from website.figures import style
from website.figures.tables import table
from website.staging import DOCS

READER_CARD = DOCS.parent / "agents" / "reading" / "reader" / "card.md"
POLICY_CARD = DOCS.parent / "agents" / "vl_map" / "card.md"

READER, POLICIES = "learning-reader", "learning-vl-map"
"""Names of the charts."""

SECTION, FIRST_COLUMN = "Learning curve", "updates"
"""Section and first column of the tables."""

LANGUAGES = {"English": style.FIRST, "Hindi": style.SECOND}
"""Languages with the colours of their curves."""

SHARES = {"rows": "o-", "texts": "s--"}
"""Columns of a language, with the style of their curves: rows, and whole texts, that are read exactly right."""


POLICY_COLOURS = {"policy 1": style.FIRST, "policy 2": style.SECOND, "policy 3": style.THIRD}
"""Columns of the table of `vl_map`, with the colours of their curves."""


def rows(name: str) -> list[dict[str, Any]]:
    """Return the data of a chart: updates so far, loss, and for the reader the shares that are read exactly right."""
    card = READER_CARD if name == READER else POLICY_CARD
    return [dict(row) for row in table(card, SECTION, FIRST_COLUMN)]


def draw_policies(target: Path) -> None:
    """Draw the chart of `vl_map`."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot as plt

    data = rows(POLICIES)
    with mpl.rc_context(style.settings()):
        figure, axis = plt.subplots(figsize=(8.2, 2.8))
        for column, colour in POLICY_COLOURS.items():
            updates = [int(row[FIRST_COLUMN]) for row in data]
            axis.plot(updates, [float(row[column]) for row in data], "o-", color=colour, markersize=4, label=column)
        axis.set_title("loss, mean since the point before", loc="left")
        axis.set_ylim(bottom=0)
        axis.set_xlabel("updates", color=style.SOFT)
        axis.legend(frameon=False, labelcolor=style.INK, loc="lower right")
        axis.grid(axis="y")
        axis.tick_params(length=0)
        figure.tight_layout()
        style.save(figure, data, target)
        plt.close(figure)


def draw_reader(target: Path) -> None:
    """Draw the chart of the reader."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot as plt

    data = rows(READER)
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

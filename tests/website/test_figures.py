"""The figures: drawn from the tables as they are, and by all of them."""

import xml.etree.ElementTree as ET
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from tests import ROOT
from website.figures import ablations, drawings, language, learning, results, speed, style
from website.figures.tables import difference, read_tables, table

FOLDER = ROOT / "docs" / "figures"

RENEW = "renew it with: python -m website.figures"

CHARTS = (
    {name: results.rows(metric) for metric, name in results.METRICS.items()}
    | {name: ablations.rows(name) for name in ablations.CHARTS}
    | {name: language.rows(name) for name in language.CHARTS}
    | {speed.NAME: speed.rows()}
    | {name: learning.rows(name) for name in (learning.READER, learning.POLICIES)}
)


@pytest.mark.parametrize("name", CHARTS)
def test_a_chart_is_up_to_date_with_its_table(name: str) -> None:
    data = style.as_csv(CHARTS[name])
    assert (FOLDER / f"{name}.csv").read_text(encoding="utf-8") == data, RENEW
    svg = (FOLDER / f"{name}.svg").read_text(encoding="utf-8")
    assert style.stamp(data) in svg, RENEW
    ET.fromstring(svg)


def test_drawings_are_up_to_date() -> None:
    for name, text in drawings.all_drawings().items():
        assert (FOLDER / f"{name}.svg").read_text(encoding="utf-8") == text, RENEW
        ET.fromstring(text)


def test_every_figure_is_made_by_the_command_and_shown_with_its_data() -> None:
    names = {*CHARTS, *drawings.all_drawings()}
    assert {path.stem for path in FOLDER.iterdir()} == names
    pages = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "docs").rglob("*.md"))
    assert [name for name in names if f"figures/{name}.svg)" not in pages] == []
    assert [name for name in CHARTS if f"(../figures/{name}.csv)" not in pages] == []


def test_a_chart_is_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="the extra `docs` is not installed: scripts/setup dev")
    results.draw("nDTW", tmp_path / "a.svg")
    svg = (tmp_path / "a.svg").read_text(encoding="utf-8")
    for text in ("vl_map", "the paper&#x27;s V/L", "val_unseen", "English", "Hindi"):
        assert text in svg or text.replace("&#x27;", "'") in svg
    assert not [colour for colour in style.VARIABLES if colour in svg]
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == style.as_csv(CHARTS["results-ndtw"])


@pytest.mark.parametrize("split", results.SPLITS)
def test_the_page_has_the_intervals_of_the_chart(split: str) -> None:
    expected = results.intervals(split)
    assert f"\nOn `{split}`:\n\n{expected}\n" in results.PAGE.read_text(encoding="utf-8"), f"expected:\n{expected}"


def test_intervals_of_charts_are_those_of_the_table_of_seeds() -> None:
    """vl in English on val_seen: 1.96 * sqrt(0.143^2 / 138 + 0.205^2 / (3 * 138)) is 0.031."""
    row = next(row for row in CHARTS["results-ndtw"] if (row["agent"], row["language"]) == ("vl", "en"))
    assert (row["score"], row["low"], row["high"]) == ("0.203", "0.172", "0.234")


def test_differences_are_read() -> None:
    assert difference("**-0.082 (-0.153 to -0.012)**") == (-0.082, -0.153, -0.012)
    assert difference("+0.062 (-0.020 to +0.145)") == (0.062, -0.02, 0.145)
    assert difference("") is None
    with pytest.raises(ValueError, match=r"the cell .0\.5. is no difference"):
        difference("0.5")


def test_shares_of_both_phases_are_read_and_other_figures_left_out() -> None:
    data = CHARTS["language-phrases"]
    assert {row["phase"] for row in data} == {"navigation", "assembly"}
    assert {row["texts"] for row in data} == {"en", "people"}
    assert "words per text" not in {row["phrase"] for row in data}
    assert {row["texts"] for row in CHARTS["language-paths"]} == {"en", "hi", "people"}


def test_other_projects_and_busy_machines_are_marked() -> None:
    data = {row["name"]: row for row in CHARTS["speed-peers"]}
    assert {name for name, row in data.items() if row["project"] == "other"} == {
        "tiny (PyBullet's TinyRenderer), RGB and depth, 224", "tiny, 128", "ViZDoom, RGB and depth, 320x240",
        "MiniWorld, RGB only, 224", "MiniWorld, 224, RGB", "MiniGrid's BabyAI, no images",
    }  # fmt: skip
    assert {name for name, row in data.items() if row["machine"]} == {
        "MiniWorld, 224, RGB", "MiniGrid's BabyAI, no images",
    }  # fmt: skip


@pytest.mark.parametrize(
    "draw", [partial(language.draw, "language-paths"), speed.draw, learning.draw_reader, learning.draw_policies]
)
def test_other_charts_are_drawn(draw: Callable[[Path], None], tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="the extra `docs` is not installed: scripts/setup dev")
    draw(tmp_path / "a.svg")
    svg = (tmp_path / "a.svg").read_text(encoding="utf-8")
    ET.fromstring(svg)
    assert not [colour for colour in style.VARIABLES if colour in svg]


def test_a_missing_table_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"has no table whose first column is 'none'"):
        table(results.PAGE, "val_seen", "none")


def test_a_missing_section_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"has no section 'none'"):
        read_tables(results.PAGE, "none")

"""Results of the paper: complete, plausible, and as printed."""

from itertools import pairwise

import pytest

from arramon_server.board.reference import read_references
from arramon_server.board.standings import COLUMNS, PaperResult

LINES = read_references()
CTC = ("CTC-0", "CTC-3", "CTC-5", "CTC-7")


def find(short: str, split: str) -> PaperResult:
    (line,) = (line for line in LINES if (line.short, line.split) == (short, split))
    return line


def test_reference_covers_the_papers_agents_and_splits() -> None:
    assert [(line.split, line.short) for line in LINES] == [
        *(("val_seen", short) for short in ("V/L", "V/O", "L/O", "R/W", "S/P", "H/W")),
        *(("val_unseen", short) for short in ("V/L", "V/O", "L/O", "R/W", "S/P", "H/W")),
        *(("test_unseen", short) for short in ("V/L", "H/W", "H/E")),
    ]
    assert {line.language for line in LINES} == {"en"}
    assert all(line.source.startswith("Table") for line in LINES)


@pytest.mark.parametrize(
    ("short", "split", "total"),
    [  # once more by hand, from the paper's tables 2 and 3
        ("V/L", "val_seen", (0.135, 0.000, 0.098, 0.149, 0.200, 0.058, 0.044)),
        ("L/O", "val_unseen", (0.105, 0.000, 0.029, 0.068, 0.126, 0.017, 0.013)),
        ("H/W", "val_unseen", (0.670, 1.000, 1.000, 1.000, 1.000, 0.869, 0.856)),
        ("V/L", "test_unseen", (0.114, 0.000, 0.082, 0.122, 0.168, 0.047, 0.035)),
        ("H/E", "test_unseen", (0.806, 1.000, 1.000, 1.000, 1.000, 0.992, 0.990)),
    ],
)
def test_reference_scores_match_the_papers_tables(short: str, split: str, total: tuple[float, ...]) -> None:
    assert tuple(find(short, split).rows["total"].values()) == total


def test_metrics_missing_from_the_paper_are_missing() -> None:
    for line in LINES:
        left_out = set(COLUMNS) - set(line.rows["total"])
        assert left_out == ({"CTC-0", "rPOD@CTC-3", "PTC@CTC-3"} if line.short == "S/P" else set())


@pytest.mark.parametrize("line", LINES, ids=lambda line: f"{line.split} {line.short}")
def test_reference_scores_are_plausible(line: PaperResult) -> None:
    for row in line.rows.values():
        assert all(0.0 <= value <= 1.0 for value in row.values())
        correct = [row[name] for name in CTC if name in row]
        assert all(near <= far for near, far in pairwise(correct))
        if "PTC@CTC-3" in row:
            assert row["PTC@CTC-3"] <= row["rPOD@CTC-3"] <= row["CTC-3"]


@pytest.mark.parametrize("split", ["val_seen", "val_unseen"])
def test_the_total_is_the_mean_of_the_turns(split: str) -> None:
    rows = find("V/L", split).rows
    for metric, total in rows["total"].items():
        assert (rows["turn 1"][metric] + rows["turn 2"][metric]) / 2 == pytest.approx(total, abs=0.0011), metric

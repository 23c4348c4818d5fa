"""The ablation study: variations are trained briefly, played, cached, and compared with the base."""

import sys
from pathlib import Path
from typing import Any

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from benchmarks.agents import ablations, study, transfer  # noqa: E402
from benchmarks.agents.ablations_tables import PhaseScores, table, updates_table  # noqa: E402
from benchmarks.agents.study import write_page  # noqa: E402
from tests import tiny  # noqa: E402

NAMES = {"base": "all of it", "half": "half of it"}


def measured() -> list[PhaseScores]:
    """Two seeds of each variation in the streets; half is 0.25 worse in English."""
    found = []
    for name in NAMES:
        for seed in (1, 2):
            scores: dict[str, dict[str, dict[str, float]]] = {"en": {}, "hi": {}}
            for language, each in scores.items():
                for number, value in enumerate((0.5, 1.0, 0.75)):
                    lower = 0.25 if (name, language) == ("half", "en") else 0.0
                    each[f"val_seen/{number}"] = {"nDTW": value - lower + 0.1 * seed, "CTC-3": float(number > 0)}
            found.append(PhaseScores(name, "navigation", seed, scores, 100 * seed))
    return found


def test_variations_are_compared_with_the_base() -> None:
    lines = table(measured(), "val_seen", NAMES | {"never": "not played"}).splitlines()
    assert lines[0].startswith("|  |  | language | nDTW | minus `base` | CTC-3 | minus `base` | PTC alone |")
    assert lines[2] == "| `base` | all of it | en | 0.900 |  | 0.667 |  |  |  |"
    assert lines[4].startswith("| `half` | half of it | en | 0.650 | **-0.250 (-0.250 to -0.250)** | 0.667 | +0.000 (")
    assert lines[5].startswith("| `half` | half of it | hi | 0.900 | +0.000 (+0.000 to +0.000) |")
    assert len(lines) == 6


def test_updates() -> None:
    assert "| `half` | 150 |  |" in updates_table(measured(), NAMES)


def run(monkeypatch: pytest.MonkeyPatch, module: Any, *options: str) -> None:
    monkeypatch.setattr(sys, "argv", ["command", *options])
    module.main()


@pytest.fixture
def folders(tmp_path: Path) -> list[str]:
    for split, count in (("train", 2), ("val_seen", 2), ("val_unseen", 2)):
        tiny.write(tmp_path / "data", split, count)
    made = ["--runs", str(tmp_path / "runs"), "--cache", str(tmp_path / "cache"), "--rooms", "1", "--episodes", "1"]
    return ["--data", str(tmp_path / "data"), *made]


def test_the_command(folders: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also that nothing is trained or played again."""
    page = tmp_path / "page.md"
    page.write_text(f"Before.\n{ablations.BEGIN}\n{ablations.END}\nAfter.\n")
    quick = [
        "--seconds",
        "0.01",
        "--room-seconds",
        "0.01",
        "--rows",
        "base,no-rooms,no-sight",
        "--map-rows",
        "no-looks",
    ]
    run(monkeypatch, ablations, *folders, *quick, "--page", str(page))
    text = page.read_text()
    assert text.startswith("Before.")
    assert text.endswith("After.\n")
    for heading in ("## val_seen: `vl`", "## val_unseen: `vl`", "## val_seen: `vl_map`", "## Updates"):
        assert heading in text
    assert "| `no-rooms` | no drawn rooms | en |  |  |  |  | " in text
    assert "| `no-looks` | without looking around | hi | " in text
    monkeypatch.setattr(study, "play", None)
    run(monkeypatch, ablations, *folders, *quick, "--page", str(page))
    assert page.read_text() == text


def test_transfer_in_the_streets(folders: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"{transfer.BEGIN}\n{transfer.END}\n")
    quick = ["--seconds", "0.01", "--navigation-seconds", "0.01", "--phases", "assembly,navigation"]
    before = page.read_text()
    run(
        monkeypatch, transfer, *folders, *quick, "--rows", "word-en", "--seeds", "2", "--page", str(page), "--play-only"
    )
    assert page.read_text() == before
    run(monkeypatch, transfer, *folders, *quick, "--rows", "word-en+hi", "--page", str(page))
    text = page.read_text()
    assert text.count("| `word` | en | ") == text.count("| `word` | en and hi | ") == 3  # What was measured before too.
    for heading in ("## In the room: PTC", "## In the streets: nDTW", "## In the streets: CTC-3"):
        assert heading in text


def test_a_page_without_its_marks_is_not_written(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("Nothing.")
    with pytest.raises(ValueError, match="has no place for the tables"):
        write_page(page, "<!-- one -->", "<!-- two -->", "| |")
    assert page.read_text() == "Nothing."


def test_unknown_rows_are_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        run(monkeypatch, ablations, "--rows", "no-legs")
    assert "--rows no-legs: there are base, variants, pooled" in capsys.readouterr().err

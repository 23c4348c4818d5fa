"""The table of the learned reader's exact-match accuracy."""

import sys
from dataclasses import replace
from pathlib import Path

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from arramon_server.episodes.episode import Instructions  # noqa: E402
from arramon_server.episodes.splits import write_split  # noqa: E402
from benchmarks.agents import reading  # noqa: E402
from tests import tiny  # noqa: E402

TEXTS = {
    "en": Instructions(
        "Turn left and pick up the striped red mug.", "Put the mug to the left of the dotted white bowl."
    ),
    "hi": Instructions("बाएँ मुड़ें और धारीदार लाल मग उठा लें।", "मग को बिंदीदार सफ़ेद कटोरे के बाईं ओर रखें।"),
}


def test_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    episode = replace(tiny.episode("1"), instructions={code: (text, text) for code, text in TEXTS.items()})
    write_split(tmp_path, "one", hidden=False, source="tests", episodes=[episode], sections=[tiny.SECTION])

    monkeypatch.setattr(sys, "argv", ["reading", "--data", str(tmp_path), "--splits", "one"])
    reading.main()
    lines = capsys.readouterr().out.splitlines()

    assert lines[0] == "|  | en, street | en, room | hi, street | hi, room |"
    rows, texts = ([cell.strip() for cell in line.strip("| ").split("|")] for line in lines[2:])
    assert (rows[0], texts[0]) == ("`one`, rows", "`one`, texts")
    assert [rows[1], rows[3], texts[1], texts[3]] == ["1.000"] * 4
    assert all(float(whole) <= float(part) <= 1.0 for part, whole in zip(rows[1:], texts[1:], strict=True))

"""Accuracy of the visual encoder on two frames."""

import sys

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from benchmarks.agents import eyes  # noqa: E402


@pytest.mark.slow
def test_the_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Most of the time goes into building the streets."""
    monkeypatch.setattr(sys, "argv", ["eyes", "--frames", "2"])
    eyes.main()
    classes, names, times = capsys.readouterr().out.split("\n\n")
    header, _, *rows = classes.splitlines()
    assert header == "| F1 by class | unseen | seen |"
    assert len(rows) > 50
    assert names.startswith("| collectibles by name | count | found | kind | colour | pattern | all |")
    assert "| unseen, other things called collectibles | " in names
    assert all(line.endswith(f"frame ({place}).") for line, place in zip(times.splitlines(), eyes.PLACES, strict=True))

"""Frequencies of route words in small texts."""

from dataclasses import replace
from pathlib import Path

import pytest

from arramon_server.episodes.episode import Instructions
from arramon_server.episodes.splits import write_split
from tests import tiny
from tests.benchmarks.command import numbers, printed, run

MODULE = "benchmarks.instructions.route_words"


@pytest.fixture(autouse=True)
def _without_release(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ARRAMON_RELEASE", raising=False)


def test_shares(tmp_path: Path) -> None:
    texts = (
        Instructions("Walk down the street until the corner.", "Put it down."),
        Instructions("Go on.", "Put it down."),
    )
    english = replace(tiny.episode("0", ("en",)), instructions={"en": texts})
    write_split(
        tmp_path, "one", hidden=False, source="tests", episodes=[english, tiny.episode("1")], sections=[tiny.SECTION]
    )
    lines = printed(MODULE, tmp_path)
    assert lines[0].split() == ["en", "hi"]
    assert numbers(lines, "street, road, alley") == [25.0, 0.0]
    assert numbers(lines, "until") == [25.0, 0.0]


def test_a_folder_without_texts_is_told(tmp_path: Path) -> None:
    done = run(MODULE, tmp_path)
    assert done.returncode == 1
    assert f"{tmp_path} has no instructions in en or hi" in done.stderr

"""Sheets for readers of instructions, without path and goal."""

from dataclasses import replace
from pathlib import Path

import pytest

from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.paraphrases.collection import generated_episodes, paraphrased_section
from arramon_dataset.pictures.canvas import PINK
from arramon_dataset.plans import read_plan
from benchmarks.instructions.reader_sheets import main, numbered_objects, reader_sheet
from tests import tiny


def test_a_reader_sees_neither_the_way_nor_the_goal() -> None:
    episode = generated_episodes()[0]
    picture, page = reader_sheet(episode, 1, GenerationSite(paraphrased_section(), read_plan("6")))
    assert PINK not in {colour for _, colour in picture.getcolors(1 << 24) or ()}
    assert "GOAL" not in page
    assert "leg" not in page
    assert "target" not in page
    assert all(str(item.type) in page for item in episode.turns[0].street)


def test_the_numbers_of_objects_do_not_tell_the_target() -> None:
    episode = generated_episodes()[0]
    turn = episode.turns[0]
    turned = replace(episode, turns=(replace(turn, street=turn.street[::-1]), episode.turns[1]))
    assert numbered_objects(turned, 1) == numbered_objects(episode, 1)


def test_the_benchmark_writes_a_page_and_two_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tiny.write(tmp_path / "data", "one", 2)
    words = ["1", "--data", str(tmp_path / "data"), "--output", str(tmp_path / "out"), "--split"]
    assert main([*words, "one"]) == 0
    assert capsys.readouterr().out.split() == [str(tmp_path / "out" / name) for name in ("1-1.png", "1-2.png", "1.txt")]
    assert main([*words, "two"]) == 1
    assert "there is no split 'two'; there are one" in capsys.readouterr().err

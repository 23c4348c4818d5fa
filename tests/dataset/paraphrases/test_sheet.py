"""Sheets for writers of instructions."""

from pathlib import Path

import pytest
from PIL import Image

from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.paraphrases.sheet import writer_sheet
from arramon_dataset.pictures.canvas import PINK
from arramon_server.cli import main
from arramon_server.episodes.episode import Episode
from tests import tiny


def pink(picture: Image.Image) -> int:
    return sum(count for count, colour in picture.getcolors(1 << 24) or () if colour == PINK)


def test_a_writer_sees_the_way_and_the_goal(site: GenerationSite, episode: Episode) -> None:
    picture, page = writer_sheet(episode, 1, site)
    assert pink(picture) > 200
    assert f"target: {episode.turns[0].target.type}" in page
    assert page.count("GOAL") == 2
    assert "on top of the dotted white book" in page


def test_the_command_writes_a_page_and_two_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tiny.write(tmp_path / "data", "one", 2)
    words = ["sheets", "1", "--data", str(tmp_path / "data"), "--output", str(tmp_path / "out")]
    assert main([*words, "--split", "one"]) == 0
    assert capsys.readouterr().out.split() == [str(tmp_path / "out" / name) for name in ("1-1.png", "1-2.png", "1.txt")]
    assert main([*words, "--split", "two"]) == 1
    assert "there is no split 'two'; there are one" in capsys.readouterr().err
    assert main(["sheets", "x", *words[2:], "--split", "one"]) == 1
    assert "there is no episode 'x' in one" in capsys.readouterr().err

"""The file of what episodes ask for."""

from pathlib import Path

import pytest

from arramon_server.episodes.demands import FILE, TurnDemands, read_demands, write_demands
from arramon_server.episodes.splits import read_split, split_folder
from arramon_server.errors import BadFile
from tests import tiny

ASKED = (TurnDemands(("ahead",), ("object",), ("near",), ("behind",)), TurnDemands((), (), (), ()))


def test_demands_come_back_with_their_split(tmp_path: Path) -> None:
    split = tiny.write(tmp_path)
    folder = split_folder(tmp_path, "tiny")
    assert split.demands == {}
    write_demands(folder, split.data_hash, {"0": ASKED})
    assert read_split(folder).demands == {"0": ASKED}
    assert read_split(folder).data_hash == split.data_hash


def test_demands_of_other_data_are_ignored(tmp_path: Path) -> None:
    write_demands(tmp_path, "1" * 64, {"0": ASKED})
    assert read_demands(tmp_path, "1" * 64) == {"0": ASKED}
    assert read_demands(tmp_path, "2" * 64) == {}


@pytest.mark.parametrize(
    ("content", "said"), [("{", "Invalid JSON"), ('{"format": "arramon-demands"}', "version: Field required")]
)
def test_malformed_file_is_named(tmp_path: Path, content: str, said: str) -> None:
    (tmp_path / FILE).write_text(content)
    with pytest.raises(BadFile, match=f"{FILE}: .*{said}"):
        read_demands(tmp_path, "1" * 64)

"""The data folder: what counts as a split."""

from pathlib import Path

import pytest

from arramon_server.episodes.splits import read_named_split, read_splits
from arramon_server.errors import NotFound
from tests import tiny


def test_leftovers_of_a_killed_writer_are_not_a_split(tmp_path: Path) -> None:
    (tmp_path / "splits" / ".new-abc" / "tiny" / "sections").mkdir(parents=True)
    with pytest.raises(NotFound, match=r"there are no episodes in"):
        read_splits(tmp_path)
    tiny.write(tmp_path)
    assert list(read_splits(tmp_path)) == ["tiny"]


def test_a_split_is_read_by_name(tmp_path: Path) -> None:
    with pytest.raises(NotFound, match=r"there are no episodes in .*; make some with"):
        read_named_split(tmp_path, "train")
    tiny.write(tmp_path, "train")
    tiny.write(tmp_path, "val_seen")
    assert read_named_split(tmp_path, "val_seen").name == "val_seen"
    with pytest.raises(NotFound, match=r"there is no split 'rooms' in .*; there are train, val_seen$"):
        read_named_split(tmp_path, "rooms")

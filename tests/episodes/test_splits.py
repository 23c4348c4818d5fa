"""The data folder: what counts as a split."""

from pathlib import Path

import pytest

from arramon_server.episodes.splits import read_splits
from arramon_server.errors import NotFound
from tests import tiny


def test_leftovers_of_a_killed_writer_are_not_a_split(tmp_path: Path) -> None:
    (tmp_path / "splits" / ".new-abc" / "tiny" / "sections").mkdir(parents=True)
    with pytest.raises(NotFound, match="there are no episodes in"):
        read_splits(tmp_path)
    tiny.write(tmp_path)
    assert list(read_splits(tmp_path)) == ["tiny"]

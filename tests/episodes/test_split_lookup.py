"""Further splits are found by name, and in no list."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from arramon_server.episodes.split_lookup import SplitLookup
from arramon_server.episodes.splits import Split
from tests import tiny


class Recorder(Mapping[str, Split]):
    """Has one split, and records which names it was asked for."""

    def __init__(self, name: str, split: Split) -> None:
        self.name, self.split = name, split
        self.asked: list[str] = []

    def __getitem__(self, name: str) -> Split:
        self.asked.append(name)
        if name != self.name:
            raise KeyError(name)
        return self.split

    def __iter__(self) -> Iterator[str]:
        raise AssertionError("nobody lists these splits")

    def __len__(self) -> int:
        raise AssertionError("nobody counts these splits")


def test_further_splits_are_found_but_not_listed(tmp_path: Path) -> None:
    split = tiny.write(tmp_path, count=1)
    lookup = SplitLookup({"tiny": split})
    first, second = Recorder("a/1", split), Recorder("b/1", split)
    lookup.add(first)
    lookup.add(second)
    assert lookup["tiny"] is lookup["b/1"] is split
    assert (list(lookup), len(lookup), "a/1" in lookup, "c/1" in lookup) == (["tiny"], 1, True, False)
    for name in ("nowhere", "c/1"):
        with pytest.raises(KeyError):
            lookup[name]
    assert first.asked == ["b/1", "a/1", "c/1", "c/1"]  # names without a separator are the host's

"""Provenance: written beside a split's sections, part of its hash, and checked against what it speaks of."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from arramon_server.episodes.provenance import OriginCounts, Provenance, RecoveredLook, origins_of
from arramon_server.episodes.splits import Split, read_split, write_split
from arramon_server.errors import BadFile
from arramon_server.sim.own_furniture import OwnFurniture
from arramon_server.sim.section import Prop
from tests import tiny

CONE, BIN = Prop("cone", 1.0, 5.0, 0.0, "orange"), Prop("bin", -1.0, 5.0, 0.0)
SECTION = replace(tiny.SECTION, props=(CONE, BIN))
EPISODE = replace(tiny.episode("0"), furniture=OwnFurniture(added=(CONE, CONE, BIN, BIN), left_out=(1,)))
PROVENANCE = Provenance(
    "1",
    (RecoveredLook(0, 21.5, {"en": 20.0, "hi": 1.5}),),
    (RecoveredLook(0, 8.0),),
    {"0": ("colour", "text", "drawn", "drawn")},
)


def write(data: Path, *provenance: Provenance) -> Split:
    return write_split(
        data, "own", hidden=False, source="tests", episodes=[EPISODE], sections=[SECTION], provenance=provenance
    )


def test_provenance_is_read_back_and_part_of_the_hash(tmp_path: Path) -> None:
    split = write(tmp_path / "a", PROVENANCE)
    assert split.provenance == {"1": PROVENANCE}
    assert split.provenance["1"].prop_votes() == {0: 21.5}
    assert split.provenance["1"].building_votes() == {0: 8.0}
    hashes = {
        write(tmp_path / "b").data_hash,
        write(tmp_path / "c", replace(PROVENANCE, buildings=())).data_hash,
        split.data_hash,
    }
    assert len(hashes) == 3
    assert write(tmp_path / "d", PROVENANCE).data_hash == split.data_hash


def test_origins_are_counted_apart(tmp_path: Path) -> None:
    split = write(tmp_path, PROVENANCE)
    origins = origins_of(split.provenance.values(), split.sections)
    assert origins == OriginCounts(
        agreed_props=1, agreed_facades=1, drawn_props=1, own_coloured=1, own_text=1, own_drawn=2
    )
    assert str(origins) == (
        "1 landmark and 1 facade recovered by agreement, 1 put where an episode's own text says, "
        "1 landmark in the colour that an episode's own text says, 3 drawn (2 for single episodes)"
    )


@pytest.mark.parametrize(
    ("counts", "text"),
    [
        (OriginCounts(0, 0, 0, 0, 0, 0), ""),
        (OriginCounts(2, 0, 0, 0, 0, 0), "2 landmarks recovered by agreement"),
        (OriginCounts(0, 3, 4, 0, 0, 0), "3 facades recovered by agreement, 4 drawn"),
        (OriginCounts(0, 0, 0, 0, 5, 0), "5 put where an episode's own text says"),
    ],
)
def test_counts_of_zero_are_left_out_of_the_summary(counts: OriginCounts, text: str) -> None:
    assert str(counts) == text


def test_nothing_is_counted_where_nothing_was_recovered(tmp_path: Path) -> None:
    assert origins_of([], tiny.write(tmp_path).sections) == OriginCounts(0, 0, 0, 0, 0, 0)


@pytest.mark.parametrize(
    ("wrong", "what"),
    [
        (replace(PROVENANCE, props=(RecoveredLook(2, 1.0),)), "props names 2; section '1' has 2 props"),
        (replace(PROVENANCE, buildings=(RecoveredLook(1, 1.0),)), "buildings names 1; section '1' has 1 buildings"),
        (replace(PROVENANCE, own={"7": ()}), "own.7: there is no such episode in section '1'"),
        (replace(PROVENANCE, own={"0": ("text",)}), "own.0 has 1 origins; the episode adds 4 props"),
        (replace(PROVENANCE, section="2"), "section: is '2'; expected '2', and a section of that id"),
    ],
)
def test_provenance_must_fit_its_split(tmp_path: Path, wrong: Provenance, what: str) -> None:
    with pytest.raises(BadFile) as caught:
        write(tmp_path, wrong)
    assert what in str(caught.value)


@pytest.mark.parametrize(
    ("edit", "what"),
    [
        (
            {"own": {"0": ["text", "drawn", "drawn", "guessed"]}},
            "own.0 is 'guessed', expected one of colour, text, drawn",
        ),
        ({"props": [{"index": 0, "votes": 0}]}, "props[0]: has 0 votes; expected more than 0"),
        ({"props": [{"index": 0, "votes": 1}, {"index": 0, "votes": 2}]}, "props names the same index twice"),
        ({"props": [{"index": 0}]}, "props[0].votes: field required"),
    ],
)
def test_errors_name_the_field(tmp_path: Path, edit: dict[str, object], what: str) -> None:
    write(tmp_path, PROVENANCE)
    path = tmp_path / "splits" / "own" / "provenance" / "1.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **edit}))
    with pytest.raises(BadFile) as caught:
        read_split(path.parents[1])
    assert what in str(caught.value)

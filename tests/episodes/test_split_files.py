"""Episode files and splits: written and read back, with errors that name file, line and field."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from arramon_server.episodes.split_files import (
    EPISODE_FORMAT,
    EpisodeFileHeader,
    read_episodes,
    read_section,
    write_episodes,
)
from arramon_server.episodes.splits import read_split, read_splits, write_split
from arramon_server.errors import BadFile, NotFound, StorageError
from arramon_server.sim.own_furniture import MovedProp, OwnFurniture
from arramon_server.sim.section import Prop
from tests import tiny


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    tiny.write(tmp_path)
    return tmp_path / "splits" / "tiny"


def change(path: Path, line: int, edit: Callable[[Any], None]) -> None:
    lines = path.read_text().splitlines()
    record = json.loads(lines[line - 1])
    edit(record)
    lines[line - 1] = json.dumps(record)
    path.write_text("\n".join(lines) + "\n")


def test_written_split_is_read_back_unchanged(folder: Path) -> None:
    split = read_split(folder)
    assert list(split.episodes.values()) == [
        tiny.episode(str(i), ("en",) if i % 3 == 0 else ("en", "hi")) for i in range(6)
    ]
    assert split.sections == {"1": tiny.SECTION}
    assert split.languages == {"en": 6, "hi": 4}


def test_data_hash_depends_only_on_the_content(tmp_path: Path) -> None:
    one = tiny.write(tmp_path / "a").data_hash
    assert tiny.write(tmp_path / "b").data_hash == one
    assert tiny.write(tmp_path / "c", count=5).data_hash != one
    assert tiny.write(tmp_path / "d", hidden=True).data_hash != one


def test_playing_order_is_fixed_and_differs_from_the_file_order(folder: Path) -> None:
    order = [episode.episode_id for episode in read_split(folder).in_playing_order("en")]
    assert order == ["4", "3", "0", "1", "2", "5"]
    assert [e.episode_id for e in read_split(folder).in_playing_order("hi")] == ["4", "1", "2", "5"]


@pytest.mark.parametrize(
    ("line", "edit", "message"),
    [
        (1, lambda r: r.update(version=3), ":1: version: is 3; this release of the server reads versions 1 and 2"),
        (
            2,
            lambda r: r.update(furniture={"left_out": [0]}),
            ":2: furniture: is in a file of version 1; expected version 2 in the header",
        ),
        (1, lambda r: r.update(format="csv"), ":1: format: is 'csv', expected 'arramon-episodes'"),
        (2, lambda r: r["start"].pop("x"), ":2: start.x: field required"),
        (3, lambda r: r["turns"].pop(), ":3: turns[1]: field required"),
        (3, lambda r: r["turns"][1].update(path=[]), ":3: turns[1]: path is empty"),
        (
            3,
            lambda r: r["turns"][0]["actions"].append(9),
            ":3: turns[0].actions[3]: input should be 0, 1, 2 or 3; got 9",
        ),
        (
            4,
            lambda r: r["turns"][0]["street"][0]["type"].update(kind="cat"),
            ":4: turns[0].street[0].type: 'cat' is not one of ball, hourglass, mug, tv, book, bowl, bucket; got ",
        ),
        (5, lambda r: r.update(instructions={}), ":5: there are no instructions in any language"),
        (
            5,
            lambda r: r["instructions"]["en"][1].update(assembly=" "),
            ":5: instructions.en[1]: the assembly instruction",
        ),
        (6, lambda r: r.update(episode_id="1"), ":6: episode_id: episode '1' occurs twice"),
        (7, lambda r: r.update(section="9"), ":7: section: is '9'; there are 1 in "),
    ],
)
def test_errors_name_file_line_and_field(folder: Path, line: int, edit: Callable[[Any], None], message: str) -> None:
    path = folder / "episodes.jsonl"
    change(path, line, edit)
    with pytest.raises(BadFile) as caught:
        read_split(folder)
    assert str(caught.value).startswith(f"{path}{message}")


def test_episodes_without_furniture_are_written_as_in_version_1(folder: Path) -> None:
    lines = (folder / "episodes.jsonl").read_text().splitlines()
    assert json.loads(lines[0])["version"] == 1
    assert list(json.loads(lines[1])) == [
        "episode_id", "section", "start", "turns", "decoys", "instructions",
    ]  # fmt: skip


def test_own_furniture_is_read_back_from_version_2(tmp_path: Path) -> None:
    cone, banner = Prop("cone", 1.0, 2.0, 30.0, "blue"), Prop("banner", 0.0, 11.0, 180.0, "red", "star", "white")
    section = replace(tiny.SECTION, props=(cone, banner))
    own = replace(
        tiny.episode("0"), furniture=OwnFurniture(added=(cone,), moved=(MovedProp(0, 3.0, 4.0, 0.0),), left_out=(1,))
    )
    split = write_split(
        tmp_path, "own", hidden=False, source="tests", episodes=[own, tiny.episode("1")], sections=[section]
    )
    assert list(split.episodes.values()) == [own, tiny.episode("1")]
    assert read_episodes(tmp_path / "splits" / "own" / "episodes.jsonl")[0].version == 2


def test_version_1_cannot_hold_furniture(tmp_path: Path) -> None:
    own = replace(tiny.episode("0"), furniture=OwnFurniture(left_out=(0,)))
    with pytest.raises(ValueError, match="version 1 of the format holds no furniture; expected 2"):
        write_episodes(
            tmp_path / "e.jsonl", EpisodeFileHeader(EPISODE_FORMAT, 1, "own", hidden=False, source="tests"), [own]
        )


@pytest.mark.parametrize(
    ("furniture", "message"),
    [
        ({"left_out": [0]}, ":2: furniture: names prop 0 of section '1', which has 0"),
        (
            {"added": [{"kind": "cat", "x": 0, "z": 0, "heading": 0}]},
            ":2: furniture: there is no furniture such as a 'cat'",
        ),
        ({"added": [{"kind": "bin", "x": "left", "z": 0, "heading": 0}]}, ":2: furniture.added[0].x: "),
    ],
)
def test_errors_in_own_furniture_name_file_line_and_field(
    folder: Path, furniture: dict[str, object], message: str
) -> None:
    path = folder / "episodes.jsonl"
    change(path, 1, lambda r: r.update(version=2))
    change(path, 2, lambda r: r.update(furniture=furniture))
    with pytest.raises(BadFile) as caught:
        read_split(folder)
    assert str(caught.value).startswith(f"{path}{message}")


@pytest.mark.parametrize("damage", [b"", b"{", b"[1, 2]", b'{"episode_id": NaN}'])
def test_malformed_episode_lines_are_refused(folder: Path, damage: bytes) -> None:
    path = folder / "episodes.jsonl"
    lines = path.read_bytes().split(b"\n")
    path.write_bytes(b"\n".join([*lines[:2], damage, *lines[3:]]))
    with pytest.raises(BadFile, match=r"episodes\.jsonl:3: "):
        read_episodes(path)


def test_truncated_file_is_refused(folder: Path) -> None:
    path = folder / "episodes.jsonl"
    path.write_bytes(path.read_bytes()[:-10])
    with pytest.raises(BadFile, match=r"episodes\.jsonl:7: the file is truncated"):
        read_episodes(path)


def test_invalid_section_is_refused_naming_the_field(folder: Path) -> None:
    path = folder / "sections" / "1.json"
    path.write_text(path.read_text().replace('"height": 3.0', '"height": "tall"'))
    with pytest.raises(BadFile, match=r"1\.json: buildings\[0\]\.height: "):
        read_section(path)


def test_building_lower_than_agents_collide_is_refused(folder: Path) -> None:
    """Whether it is in the way would depend on more than its footprint."""
    path = folder / "sections" / "1.json"
    path.write_text(path.read_text().replace('"height": 3.0', '"height": 0.05'))
    with pytest.raises(
        BadFile, match=r"1\.json: buildings\[0\]\.height: is 0\.05; expected at least 0\.1, where agents"
    ):
        read_section(path)


def test_folder_without_episodes_error_suggests_an_import(tmp_path: Path) -> None:
    with pytest.raises(NotFound, match="arramon-server import-release FILE"):
        read_splits(tmp_path)


def test_unwritable_folder_is_reported(tmp_path: Path) -> None:
    (tmp_path / "splits").write_text("in the way")
    with pytest.raises(StorageError, match=r"cannot write to .*tiny: "):
        tiny.write(tmp_path)


def test_unreadable_new_split_does_not_replace_the_old_one(folder: Path) -> None:
    before = read_split(folder).data_hash
    with pytest.raises(BadFile):
        write_split(folder.parents[1], "tiny", hidden=False, source="tests", episodes=[tiny.episode("1")], sections=[])
    assert read_split(folder).data_hash == before
    assert [path.name for path in folder.parent.iterdir()] == ["tiny"]

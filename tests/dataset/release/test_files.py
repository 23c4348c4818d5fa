"""Reading and importing the official release's format: content, recovered data, and refusals."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from arramon_dataset.release.files import read_release, section_of
from arramon_dataset.release.importer import import_release, split_name
from arramon_server.episodes.splits import read_split
from arramon_server.errors import BadFile, BadInput
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Point
from arramon_server.sim.room import RoomCell, RoomPosition
from tests import tiny
from tests.release_format import HEADING, TEXTS, record


def write(path: Path, *records: Any) -> Path:
    path.write_text(json.dumps(records))
    return path


def test_release_episode_is_read_completely(tmp_path: Path) -> None:
    language, (episode,) = read_release(write(tmp_path / "x.json", record(15000)))
    assert (language, episode.episode_id, episode.section) == ("en", "15000", "2")
    assert episode.start.heading == pytest.approx(HEADING, abs=1e-3)
    first, second = episode.turns
    assert len(first.path) == 13
    assert second.path[0] == first.path[-1]
    assert first.room_path == second.room_path == (RoomCell(2, 0), RoomCell(2, 1))
    assert first.target.type == ObjectType("dotted", "yellow", "ball")
    assert isinstance(first.target.position, Point)
    assert (first.target_cell, second.target_cell) == (RoomPosition(2, 1, 2), RoomPosition(2, 2, 2))
    assert (episode.instructions["en"][0].navigation, episode.instructions["en"][1].assembly) == TEXTS["en"]
    assert (first.street[1:], episode.decoys) == ((), ())


@pytest.mark.parametrize(
    ("map_id", "section"),
    [
        (0, "1"),
        (14882, "1"),
        (15078, "2"),
        (25014, "3"),
        (35083, "4"),
        (45119, "5"),
        (64971, "6"),
        (65000, "7"),
        (9**9, "7"),
    ],
)
def test_map_ids_determine_the_section(map_id: int, section: str) -> None:
    assert section_of(map_id) == section


@pytest.mark.parametrize("turns", range(12))
def test_start_heading_is_recovered_from_path_and_actions(tmp_path: Path, turns: int) -> None:
    given = record(1)
    actions = given["gt_actionIDs"]["navi_actionIDs_gt"][0]
    actions[:0] = [2] * turns  # so many more turns to the right: the start faced that much more to the left
    _, (episode,) = read_release(write(tmp_path / "x.json", given))
    difference = episode.start.heading - (HEADING - 30 * turns)
    assert math.cos(math.radians(difference)) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda r: r.pop("gt_paths"), "[0].gt_paths: field required"),
        (lambda r: r.update(mapId="many"), "[0].mapId: input should be a valid integer"),
        (lambda r: r.update(mapId=-3), "[0] (mapId -3): mapId is negative"),
        (lambda r: r["gt_objects"].pop(), "[0].gt_objects[1]: field required"),
        (
            lambda r: r.update(gt_objects=["Green Cat", "x"]),
            "[0] (mapId 5): 'Green Cat' is not a pattern, a colour and a kind",
        ),
        (lambda r: r["gt_paths"]["navi_path_gt"][1][3].pop(), "[0].gt_paths.navi_path_gt[1][3][2]: field required"),
        (lambda r: r["gt_paths"]["navi_path_gt"][1].pop(), "gt_paths.navi_path_gt[1] has 12 points, but"),
        (
            lambda r: r["gt_paths"].update(navi_path_gt=[[], []]),
            "[0].gt_paths.navi_path_gt[0]: list should have at least 1",
        ),
        (lambda r: r["gt_actionIDs"]["navi_actionIDs_gt"][0].append(4), "input should be 0, 1, 2 or 3; got 4"),
        (
            lambda r: r["gt_actionIDs"]["navi_actionIDs_gt"][1].insert(0, 1),
            "the actions deviate from gt_paths.navi_path_gt[1] by",
        ),
        (lambda r: r["instructions"].update(navi_inst_gt=["", "x"]), "the navigation instruction is empty"),
    ],
)
def test_invalid_records_are_reported_with_their_index(
    tmp_path: Path, edit: Callable[[Any], Any], message: str
) -> None:
    given = record(5)
    edit(given)
    file = write(tmp_path / "x.json", given)
    with pytest.raises(BadFile) as caught:
        read_release(file, "en")
    assert str(caught.value).startswith(f"{file}: [0]")
    assert message in str(caught.value)


def test_duplicate_map_ids_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadFile, match="mapId 5 occurs twice"):
        read_release(write(tmp_path / "x.json", record(5), record(6), record(5)))


def test_texts_in_an_unknown_script_require_the_lang_option(tmp_path: Path) -> None:
    given = record(5)
    given["instructions"] = {name: ["直走到黄球", "放在上面"] for name in given["instructions"]}
    with pytest.raises(BadFile, match="set it with --lang"):
        read_release(write(tmp_path / "x.json", given))


@pytest.mark.parametrize("name", ["val_seen", "val_seen_hindi", "val_seen_hi", "val_seen_english"])
def test_split_name_comes_from_the_file_name(name: str) -> None:
    assert split_name(Path(f"/somewhere/{name}.json")) == "val_seen"


def test_languages_merge_in_one_import_or_in_two(tmp_path: Path) -> None:
    english = write(tmp_path / "s.json", record(1), record(2))
    hindi = write(tmp_path / "s_hindi.json", record(2, "hi"))
    (together,) = import_release([english, hindi], tmp_path / "a")
    import_release([english], tmp_path / "b")
    (after,) = import_release([hindi], tmp_path / "b")
    assert together.languages == {"en": 2, "hi": 1}
    assert after.data_hash == together.data_hash
    assert list(together.episodes["2"].instructions) == ["en", "hi"]


def test_repeated_import_changes_nothing(tmp_path: Path) -> None:
    file = write(tmp_path / "s.json", record(1), record(2))
    hashes = {import_release([file], tmp_path / "data")[0].data_hash for _ in range(2)}
    assert len(hashes) == 1


def test_hindi_can_be_imported_without_english(tmp_path: Path) -> None:
    (split,) = import_release([write(tmp_path / "s_hindi.json", record(1, "hi"))], tmp_path)
    assert (split.name, split.languages) == ("s", {"hi": 1})


def test_contradicting_import_is_refused_and_changes_nothing(tmp_path: Path) -> None:
    (before,) = import_release([write(tmp_path / "s.json", record(1))], tmp_path)
    other_text, other_path = record(1), record(1, "hi", steps=9)
    other_text["instructions"]["navi_inst_gt"][0] = "Go back."
    for given, message in ((other_text, "has other 'en' instructions"), (other_path, "has other paths or targets")):
        with pytest.raises(BadFile, match=message):
            import_release([write(tmp_path / "s.json", given)], tmp_path)
    assert read_split(tmp_path / "splits" / "s").data_hash == before.data_hash


def test_import_does_not_overwrite_a_split_from_another_source(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    with pytest.raises(BadInput, match="split 'tiny' exists and was not imported; choose another name with --split"):
        import_release([write(tmp_path / "tiny.json", record(1))], tmp_path)


def test_an_import_can_be_hidden(tmp_path: Path) -> None:
    (split,) = import_release([write(tmp_path / "s.json", record(1))], tmp_path, hidden=True)
    assert split.hidden
    assert split.sensors == ("rgb", "depth")

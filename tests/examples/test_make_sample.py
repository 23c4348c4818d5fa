import json
import subprocess
import sys
import unicodedata
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arramon_lang as lang
from arramon_dataset.randomness import seeded
from arramon_dataset.release.files import read_release
from arramon_dataset.release.importer import import_release
from arramon_dataset.release.missing_objects import read_references
from arramon_server.episodes.episode import Episode
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import moved
from benchmarks.release.drawn_furniture import reconstruct
from examples.sampling import english, hindi
from examples.sampling.rooms import OFFSETS
from examples.sampling.routes import RouteLeg
from tests import ROOT

SAMPLE = ROOT / "examples" / "sample"
FILES = ("sample.json", "sample_hindi.json")
MUG = ObjectType("striped", "red", "mug")


@pytest.fixture(scope="module")
def episodes() -> list[Episode]:
    return read_release(SAMPLE / "sample.json")[1]


def records(name: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads((SAMPLE / name).read_text(encoding="utf-8"))
    return found


def test_sample_generation_is_reproducible(tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-m", "examples.make_sample", "--output", tmp_path], cwd=ROOT, check=True)

    for name in FILES:
        assert (tmp_path / name).read_bytes() == (SAMPLE / name).read_bytes()
    assert sum((SAMPLE / name).stat().st_size for name in FILES) < 400_000


def test_english_and_hindi_files_hold_the_same_episodes() -> None:
    one, other = (records(name) for name in FILES)

    assert len(one) == 24
    keys = "mapId code filename instructions gt_objects gt_objects_pos gt_paths gt_actions gt_actionIDs"
    assert one[0].keys() == set(keys.split())
    for english_record, hindi_record in zip(one, other, strict=True):
        assert english_record.pop("instructions") != hindi_record.pop("instructions")
        assert english_record == hindi_record


@pytest.mark.parametrize(("name", "language"), [("sample.json", "en"), ("sample_hindi.json", "hi")])
def test_importer_reads_the_sample(name: str, language: str) -> None:
    found, read = read_release(SAMPLE / name)

    assert found == language
    assert [episode.section for episode in read] == ["1"] * 12 + ["2"] * 12


def test_ground_truth_actions_end_with_the_target_ahead(episodes: list[Episode]) -> None:
    for episode in episodes:
        pose = episode.start
        assert (pose.heading - 28.8 + 15.0) % 30.0 == pytest.approx(15.0, abs=0.01)
        for turn in episode.turns:
            pose = reduce(moved, turn.actions, pose)
            right, ahead = pose.local(turn.target.position.x, turn.target.position.z)
            assert abs(right) <= 0.5
            assert 1.0 <= ahead <= 2.0
            assert 15 <= len(turn.path) <= 46


def test_sample_rooms_have_floor_raised_and_stacked_placements(episodes: list[Episode]) -> None:
    cells = [tuple(turn.target_cell for turn in episode.turns) for episode in episodes]

    stacked = [first for first, second in cells if (second.column, second.row) == (first.column, first.row)]
    assert len(stacked) >= 2
    assert 6 <= sum(cell.level == 2 for pair in cells for cell in pair) <= 30
    assert all(cell.level in (1, 2) for pair in cells for cell in pair)


def test_assembly_instructions_match_the_rooms(tmp_path: Path) -> None:
    split = import_release([SAMPLE / name for name in FILES], tmp_path)[0]
    checked = 0
    for episode in split.episodes.values():
        first, second = episode.turns
        room = {RoomCell(item.placement.column, item.placement.row): item.type for item in episode.decoys}
        assert len(room) == 8
        for number, turn in enumerate((first, second)):
            cell = turn.target_cell
            for code, texts in episode.instructions.items():
                for reference in read_references(texts[number].assembly, lang.load(code)):
                    name = reference.complete_type()
                    if reference.relation is not None and name is not None:
                        columns, rows = OFFSETS[reference.relation]
                        assert room[RoomCell(cell.column + columns, cell.row + rows)] == name, texts[number].assembly
                        checked += 1
            room.setdefault(RoomCell(cell.column, cell.row), turn.target.type)
    assert checked > 40


def test_both_languages_name_the_same_objects() -> None:
    for one, other in zip(*(records(name) for name in FILES), strict=True):
        for turn, target in enumerate(one["gt_objects"]):
            for code, record in (("en", one), ("hi", other)):
                text = record["instructions"]["navi_inst_gt"][turn]
                (mention,) = (m for m in lang.load(code).find_objects(text) if m.kind)
                assert f"{mention.pattern} {mention.colour} {mention.kind}".title() == target.title()


def test_hindi_texts_are_normalised_and_end_in_a_danda() -> None:
    for record in records("sample_hindi.json"):
        for text in (*record["instructions"]["navi_inst_gt"], *record["instructions"]["assem_inst_gt"]):
            assert unicodedata.is_normalized("NFC", text)
            assert text.endswith("।")
            assert " ।" not in text


@pytest.mark.parametrize(
    ("thing", "oblique", "expected"),
    [
        (ObjectType("striped", "blue", "bowl"), False, "धारीदार नीला कटोरा"),
        (ObjectType("striped", "blue", "bowl"), True, "धारीदार नीले कटोरे"),
        (ObjectType("dotted", "green", "tv"), True, "बिंदीदार हरे टीवी"),
        (ObjectType("dotted", "yellow", "book"), False, "बिंदीदार पीली किताब"),
        (ObjectType("dotted", "brown", "bucket"), True, "बिंदीदार भूरी बाल्टी"),
        (ObjectType("striped", "purple", "mug"), True, "धारीदार बैंगनी मग"),
        (ObjectType("striped", "red", "ball"), True, "धारीदार लाल गेंद"),
    ],
)
def test_hindi_object_names_agree_in_gender_and_case(thing: ObjectType, oblique: bool, expected: str) -> None:
    assert hindi.name(thing, oblique=oblique) == expected


@pytest.mark.parametrize(
    ("legs", "side", "in_english", "in_hindi"),
    [
        (
            [RouteLeg(2, False, 1, "+"), RouteLeg(-1, True, 0, "")],
            "a",
            "to the second intersection. Turn left into the alley and ",
            "दूसरे चौराहे तक ",
        ),
        (
            [RouteLeg(0, False, 2, "L"), RouteLeg(1, False, 0, "")],
            "right",
            "past two intersections to the corner.",
            "दो चौराहों से आगे निकलकर नुक्कड़ तक ",
        ),
        (
            [RouteLeg(1, False, 1, "")],
            "L",
            "past the intersection to the striped red mug at the corner.",
            "नुक्कड़ पर रखा धारीदार लाल मग ",
        ),
    ],
)
def test_navigation_instructions_describe_the_legs(
    legs: list[RouteLeg], side: str, in_english: str, in_hindi: str
) -> None:
    assert in_english in english.navigate(legs, MUG, side, seeded(1))
    assert unicodedata.normalize("NFC", in_hindi) in hindi.navigate(legs, MUG, side, seeded(1))


def test_sample_streets_can_be_reconstructed(episodes: list[Episode]) -> None:
    for section in ("1", "2"):
        turns = [turn for episode in episodes if episode.section == section for turn in episode.turns]
        targets = np.array([(turn.target.position.x, turn.target.position.z) for turn in turns])
        rebuilt = reconstruct(section, [np.array(turn.path) for turn in turns], targets)
        assert rebuilt.heading in (28.8, 118.8)
        assert 20 <= len(rebuilt.buildings) <= 100
        assert len(rebuilt.props) >= 60

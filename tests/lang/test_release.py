"""Share of the official release's English instructions that is understood."""

import json
import os
from pathlib import Path
from typing import Any

import pytest

from arramon_lang import load
from tests import ROOT

RELEASE = Path(os.environ.get("ARRAMON_RELEASE", ROOT.parent / "shared" / "release"))
FILE = RELEASE / "val_seen.json"

pytestmark = pytest.mark.skipif(
    not FILE.is_file(), reason=f"no {FILE}: set ARRAMON_RELEASE to the folder of the official release to run this"
)


@pytest.fixture(scope="module")
def episodes() -> list[dict[str, Any]]:
    loaded: list[dict[str, Any]] = json.loads(FILE.read_text(encoding="utf-8"))
    return loaded


def landmarks(text: str) -> list[tuple[str | None, str | None, str | None]]:
    """Return the objects that something is on top of, according to the text."""
    english = load("en")
    return [
        (mention.pattern, mention.colour, mention.kind)
        for mention in english.find_objects(text)
        if english.relation_of(text, mention) == "on_top_of"
    ]


def test_objects_under_level_2_targets_are_read(episodes: list[dict[str, Any]]) -> None:
    texts = [
        episode["instructions"]["assem_inst_gt"][turn]
        for episode in episodes
        for turn in (0, 1)
        if episode["gt_objects_pos"]["assem_obj_pos_gt"][turn][1] == 2
    ]
    assert len(texts) == 650
    read = [any(kind for _, _, kind in landmarks(text)) for text in texts]
    assert sum(read) / len(read) >= 0.98


def test_object_under_a_level_2_target_is_the_correct_one(episodes: list[dict[str, Any]]) -> None:
    # Where the second target stands on the first, the release tells what the landmark is.
    right = []
    for episode in episodes:
        (column, _, row), (on_column, level, on_row) = episode["gt_objects_pos"]["assem_obj_pos_gt"]
        found = landmarks(episode["instructions"]["assem_inst_gt"][1])
        if level == 2 and (column, row) == (on_column, on_row) and found:
            truth = episode["gt_objects"][0].lower().split()
            right.append(all(said in (None, true) for said, true in zip(found[0], truth, strict=True)))
    assert len(right) > 50
    assert sum(right) / len(right) >= 0.95


def test_the_target_is_found_in_its_navigation_instruction(episodes: list[dict[str, Any]]) -> None:
    found = []
    for episode in episodes:
        for text, name in zip(episode["instructions"]["navi_inst_gt"], episode["gt_objects"], strict=True):
            truth = name.lower().split()
            mentions = [(m.pattern, m.colour, m.kind) for m in load("en").find_objects(text) if m.kind]
            found.append(any(all(s in (None, t) for s, t in zip(said, truth, strict=True)) for said in mentions))
    assert sum(found) / len(found) >= 0.99

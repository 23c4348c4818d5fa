"""Demonstrations of the expert in both languages, rendered once."""

from pathlib import Path

import numpy as np

from arramon_agents.training import demonstrations
from arramon_agents.training.demonstrations import ROOMS, DemonstrationSource, PhaseDemonstration, collect
from tests import tiny


def gathered(source: DemonstrationSource, cache: Path) -> list[PhaseDemonstration]:
    return [each for part in collect(source, cache) for each in part]


def test_they_are_the_ground_truth_in_every_language_there_is(data: Path, tmp_path: Path) -> None:
    found = gathered(DemonstrationSource(data, "train", ("en", "hi"), "pooled", 0), tmp_path)
    by_key = {(each.episode_id, each.turn, each.phase): each for each in found}
    assert len(by_key) == len(found) == 6 * 4
    for episode_id in "012345":
        phases = [(1, "navigation"), (1, "assembly"), (2, "navigation"), (2, "assembly")]
        actions = [action for phase in phases for action in by_key[(episode_id, *phase)].actions.tolist()]
        assert actions == list(tiny.ACTIONS)
        texts = by_key[episode_id, 1, "navigation"].texts
        assert texts.get("hi") == (None if int(episode_id) % 3 == 0 else "धारीदार लाल मग तक चलें।")
        assert texts["en"] == "Go on to the striped red mug."


def test_what_is_there_is_not_drawn_again(data: Path, tmp_path: Path) -> None:
    source = DemonstrationSource(data, "train", ("en",), "pooled", 2)
    first = gathered(source, tmp_path)
    written = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.zst")}
    again = gathered(source, tmp_path)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.zst")} == written
    for one, other in zip(first, again, strict=True):
        assert (one.episode_id, one.turn, one.phase, one.texts) == (
            other.episode_id, other.turn, other.phase, other.texts,
        )  # fmt: skip
        np.testing.assert_array_equal(one.features, other.features)


def test_for_the_blind_nothing_is_drawn(data: Path, tmp_path: Path) -> None:
    found = gathered(DemonstrationSource(data, "train", ("en", "hi"), "", 1), tmp_path)
    assert [each.features.shape for each in found] == [(len(each.actions), 7, 7, 0) for each in found]
    assert sum(len(each.actions) for each in found) == len(tiny.ACTIONS)


def test_several_processes_draw_the_same(data: Path, tmp_path: Path) -> None:
    source = DemonstrationSource(data, "train", ("en",), "pooled", 3)
    alone = gathered(source, tmp_path / "alone")
    together = [each for part in collect(source, tmp_path / "together", processes=2) for each in part]
    for one, other in zip(alone, together, strict=True):
        assert one.episode_id == other.episode_id
        np.testing.assert_array_equal(one.features, other.features)


def test_other_languages_have_their_own_cache(data: Path, tmp_path: Path) -> None:
    gathered(DemonstrationSource(data, "train", ("en",), "pooled", 2), tmp_path)
    gathered(DemonstrationSource(data, "train", ("hi",), "pooled", 2), tmp_path)
    assert len(list(tmp_path.iterdir())) == 2


def test_drawn_rooms_tell_one_task_in_both_languages(data: Path, tmp_path: Path) -> None:
    found = gathered(DemonstrationSource(data, ROOMS, ("en", "hi"), "pooled", 3), tmp_path)
    assert {each.phase for each in found} == {"assembly"}
    assert len(found) == 6
    assert all(each.actions[-1] == 3 for each in found)
    assert sum("hi" in each.texts for each in found) >= 4


def test_files_are_as_they_were_written(tmp_path: Path) -> None:
    features = np.random.default_rng(1).integers(0, 256, (3, 7, 7, 5), np.uint8)
    made = PhaseDemonstration("a", 2, "assembly", {"hi": "रखें"}, np.array([0, 1, 3], np.uint8), features)
    demonstrations.write_demonstrations(tmp_path / "part.zst", [made, made])
    for each in demonstrations.read_demonstrations(tmp_path / "part.zst"):
        assert (each.episode_id, each.turn, each.phase, each.texts) == ("a", 2, "assembly", {"hi": "रखें"})
        assert each.actions.tolist() == [0, 1, 3]
        np.testing.assert_array_equal(each.features, features)

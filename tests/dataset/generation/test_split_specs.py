"""Specifications of splits: sizes, ids and scales."""

import pytest

from arramon_dataset.generation.split_specs import SPLITS, select_specs
from arramon_server.errors import BadInput


def test_splits_have_the_expected_sizes_and_sections() -> None:
    assert {name: (plan.count(1.0), "".join(plan.sections), plan.hidden) for name, plan in SPLITS.items()} == {
        "train": (4267, "12345", False),
        "val_seen": (1065, "12345", False),
        "val_unseen": (1155, "6", False),
        "test_unseen": (1205, "7", True),
    }


def test_episode_ids_are_unique_and_encode_their_section() -> None:
    given = [(episode_id, section) for plan in SPLITS.values() for episode_id, section in plan.episodes()]

    assert len({episode_id for episode_id, _ in given}) == len(given) == 7692
    for episode_id, section in given:
        assert (int(episode_id) - 5000) // 10_000 + 1 == int(section)


@pytest.mark.parametrize(
    ("name", "scale", "count"), [("val_seen", 0.01, 11), ("train", 0.0001, 1), ("train", 0.5, 2134)]
)
def test_smaller_scale_takes_the_first_episodes(name: str, scale: float, count: int) -> None:
    assert list(SPLITS[name].episodes(scale)) == list(SPLITS[name].episodes())[:count]


@pytest.mark.parametrize("scale", [0.0, -1.0, 1.5, float("nan")])
def test_a_scale_out_of_range_is_refused(scale: float) -> None:
    with pytest.raises(BadInput, match="scale"):
        SPLITS["train"].count(scale)


def test_splits_are_chosen_by_name() -> None:
    assert [plan.name for plan in select_specs(["val_unseen", "train"])] == ["train", "val_unseen"]
    assert [plan.name for plan in select_specs(None)] == list(SPLITS)
    with pytest.raises(BadInput, match="'val'"):
        select_specs(["val"])

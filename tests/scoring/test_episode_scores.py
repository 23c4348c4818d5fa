"""Scores of a turn: gates, forced ends, and phases that were not played."""

import dataclasses
import math
from typing import Any

import pytest

from arramon_server.scoring.episode_scores import METRICS, score_episode, score_turn
from arramon_server.scoring.trajectory import EpisodeRecord, TurnRecord

PERFECT = TurnRecord(
    reference_path=((0.0, 0.0), (0.0, 1.0), (0.0, 2.0)),
    target_position=(0.0, 0.025, 3.0),
    target_cell=(2, 1, 3),
    path=((0.0, 0.0), (0.0, 0.0), (0.0, 1.0), (0.0, 2.0), (0.0, 2.0)),
    navigation_ended=True,
    final_position=(0.0, 0.525, 2.0),
    picked_target=True,
    placed_cell=(2, 1, 3),
)
UNPLAYED = TurnRecord(PERFECT.reference_path, PERFECT.target_position, PERFECT.target_cell)


def scores(**changes: Any) -> dict[str, float]:
    return dict(score_turn(dataclasses.replace(PERFECT, **changes)))


def test_the_metrics_are_in_the_papers_order() -> None:
    assert METRICS == (
        "nDTW", "CTC-0", "CTC-3", "CTC-5", "CTC-7", "rPOD", "PTC",
        "rPOD@CTC-0", "PTC@CTC-0", "rPOD@CTC-3", "PTC@CTC-3", "rPOD@CTC-5", "PTC@CTC-5", "rPOD@CTC-7", "PTC@CTC-7",
    )  # fmt: skip
    assert tuple(scores()) == METRICS


def test_perfect_turn_scores_one_in_every_metric() -> None:
    assert scores() == dict.fromkeys(METRICS, 1.0)


@pytest.mark.parametrize(
    ("picked", "ahead", "expected"),
    [
        # The wrong object beside the target passes every gate but CTC-0.
        (False, 1.0, {"CTC-0": 0.0, "CTC-3": 1.0, "CTC-5": 1.0, "CTC-7": 1.0}),
        (False, 4.0, {"CTC-0": 0.0, "CTC-3": 0.0, "CTC-5": 1.0, "CTC-7": 1.0}),
        (False, 6.0, {"CTC-0": 0.0, "CTC-3": 0.0, "CTC-5": 0.0, "CTC-7": 1.0}),
        (False, 9.0, {"CTC-0": 0.0, "CTC-3": 0.0, "CTC-5": 0.0, "CTC-7": 0.0}),
        # The target itself from afar (a forced pick-up) passes CTC-0 alone.
        (True, 9.0, {"CTC-0": 1.0, "CTC-3": 0.0, "CTC-5": 0.0, "CTC-7": 0.0}),
    ],
)
def test_placement_is_gated_by_each_ctc_of_the_same_turn(
    picked: bool, ahead: float, expected: dict[str, float]
) -> None:
    result = scores(picked_target=picked, final_position=(0.0, 0.525, 3.0 - ahead), placed_cell=(2, 1, 2))
    assert {gate: result[gate] for gate in expected} == expected
    assert (result["rPOD"], result["PTC"]) == (0.5, 0.0)
    for gate, passed in expected.items():
        assert result[f"rPOD@{gate}"] == 0.5 * passed
        assert result[f"PTC@{gate}"] == 0.0
    placed_right = scores(picked_target=picked, final_position=(0.0, 0.525, 3.0 - ahead))
    assert placed_right["PTC"] == 1.0
    assert {gate: placed_right[f"PTC@{gate}"] for gate in expected} == expected


def test_forced_placement_scores_zero_even_if_correct() -> None:
    result = scores(placement_forced=True)
    placement = [name for name in METRICS if name.startswith(("rPOD", "PTC"))]
    assert {name: result[name] for name in placement} == dict.fromkeys(placement, 0.0)
    assert result["nDTW"] == result["CTC-0"] == result["CTC-3"] == 1.0


def test_forced_pick_up_does_not_change_the_scores() -> None:
    assert scores(pickup_forced=True) == scores()


def test_unfinished_assembly_scores_no_placement() -> None:
    result = scores(placed_cell=None)
    assert (result["rPOD"], result["PTC"], result["rPOD@CTC-3"]) == (0.0, 0.0, 0.0)
    assert (result["nDTW"], result["CTC-0"], result["CTC-7"]) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    "turn",
    [
        UNPLAYED,
        # Cut short on its way, even where it stood beside the target.
        dataclasses.replace(UNPLAYED, path=PERFECT.path),
        dataclasses.replace(PERFECT, navigation_ended=False),
    ],
)
def test_unfinished_navigation_scores_zero_in_every_metric(turn: TurnRecord) -> None:
    assert score_turn(turn) == dict.fromkeys(METRICS, 0.0)


def test_ndtw_compares_the_turns_own_paths() -> None:
    assert scores(path=((0.0, 0.0),))["nDTW"] == pytest.approx(math.exp(-3 / 9))


def test_missing_reference_path_is_an_error_even_for_unplayed_turns() -> None:
    with pytest.raises(ValueError, match="reference path is empty"):
        score_turn(dataclasses.replace(UNPLAYED, reference_path=()))


def test_an_episode_has_the_scores_of_both_turns() -> None:
    result = score_episode(EpisodeRecord("8900", "1", (PERFECT, UNPLAYED)))
    assert (result.episode_id, result.section) == ("8900", "1")
    assert result.turns == (score_turn(PERFECT), score_turn(UNPLAYED))

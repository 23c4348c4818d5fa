"""Scores of groups of turns."""

import numpy as np
import pytest

from server.scoring.aggregate import table_rows, with_total
from server.scoring.breakdown import SHOWN, group_scores
from server.scoring.episode import METRICS

EPISODES = 60
SECTIONS = np.arange(EPISODES) % 3


def made(seed: int = 0) -> "np.typing.NDArray[np.float64]":
    return (np.random.default_rng(seed).random((EPISODES, 2, len(METRICS))) < 0.4).astype(float)


@pytest.mark.parametrize(("row", "turns"), [("turn 1", (0,)), ("turn 2", (1,)), ("total", (0, 1))])
def test_groups_that_are_rows_of_the_table_have_its_scores(row: str, turns: tuple[int, ...]) -> None:
    """The interval of the total, too: the turns of an episode are not taken for independent."""
    scores = made()
    group = np.zeros((EPISODES, 2), dtype=bool)
    group[:, turns] = True
    found = group_scores(scores, group, SECTIONS, rounded=False)
    table = table_rows(with_total(scores), SECTIONS)[row]
    assert (found.turns, found.episodes) == (EPISODES * len(turns), EPISODES)
    for metric in SHOWN:
        one, other = found.scores[metric], table[metric]
        assert (one.mean, one.low, one.high) == pytest.approx((other.mean, other.low, other.high))


def test_the_mean_is_over_turns() -> None:
    scores = made()
    group = np.random.default_rng(1).random((EPISODES, 2)) < 0.3
    found = group_scores(scores, group, SECTIONS, rounded=False)
    for metric in SHOWN:
        assert found.scores[metric].mean == pytest.approx(scores[:, :, METRICS.index(metric)][group].mean())
    assert found.turns == group.sum()


def test_intervals_cover_the_mean_of_a_group_whose_episodes_have_one_or_two_turns_in_it() -> None:
    """True mean 0.3, both turns of an episode alike: 95 of 100 intervals hold it, more or less."""
    draw, number, covered = np.random.default_rng(2), 150, 0
    group = draw.random((number, 2)) < (0.9, 0.3)
    for _ in range(400):
        outcome = (draw.random(number) < 0.3).astype(float)
        scores = np.broadcast_to(outcome[:, None, None], (number, 2, len(METRICS)))
        found = group_scores(scores, group, np.zeros(number, np.intp), rounded=False).scores["PTC"]
        covered += found.low <= 0.3 <= found.high
    assert 0.92 <= covered / 400 <= 0.98


def test_rounded_scores_hide_one_episode() -> None:
    group = np.ones((EPISODES, 2), dtype=bool)
    none = np.zeros((EPISODES, 2, len(METRICS)))
    one = none.copy()
    one[7] = 1.0
    found = [group_scores(scores, group, SECTIONS, rounded=True).scores["nDTW"] for scores in (none, one)]
    assert found[0] == found[1]
    exact = [group_scores(scores, group, SECTIONS, rounded=False).scores["nDTW"] for scores in (none, one)]
    assert exact[0] != exact[1]


def test_rounded_intervals_are_wider_and_on_the_grid() -> None:
    scores, group = made(3), np.ones((EPISODES, 2), dtype=bool)
    rounded, exact = (group_scores(scores, group, SECTIONS, rounded=flag).scores["PTC"] for flag in (True, False))
    assert rounded.low <= exact.low <= exact.high <= rounded.high
    for end in (rounded.low, rounded.mean, rounded.high):
        assert end * 20 == pytest.approx(round(end * 20))  # 120 turns: steps of 0.05

"""Scores of groups of turns."""

import numpy as np
import pytest

from arramon_server.scoring.aggregate import table_rows, with_total
from arramon_server.scoring.breakdown import SHOWN, group_scores, masked_group_scores
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.scoring.masking import Noise, masked_rows

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
    found = group_scores(scores, group, SECTIONS)
    table = table_rows(with_total(scores), SECTIONS)[row]
    assert (found.turns, found.episodes) == (EPISODES * len(turns), EPISODES)
    for metric in SHOWN:
        one, other = found.scores[metric], table[metric]
        assert (one.mean, one.low, one.high) == pytest.approx((other.mean, other.low, other.high))


def test_the_mean_is_over_turns() -> None:
    scores = made()
    group = np.random.default_rng(1).random((EPISODES, 2)) < 0.3
    found = group_scores(scores, group, SECTIONS)
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
        found = group_scores(scores, group, np.zeros(number, np.intp)).scores["PTC"]
        covered += found.low <= 0.3 <= found.high
    assert 0.92 <= covered / 400 <= 0.98


def test_masked_groups_have_noise_of_their_own_and_rows_are_those_of_the_table() -> None:
    scores, noise = made(3), Noise(b"key")
    rows = masked_rows(scores, noise, "play")
    first = np.broadcast_to([True, False], (EPISODES, 2))
    found = masked_group_scores(scores, first, rows, noise, ("play", "turn", "first"))
    assert found.scores == {metric: rows["turn 1"][metric] for metric in SHOWN}
    assert (found.turns, found.episodes) == (EPISODES, EPISODES)
    some = np.random.default_rng(1).random((EPISODES, 2)) < 0.5
    shown = [masked_group_scores(scores, some, rows, noise, ("play", "length", name)).scores for name in "abcdefgh"]
    assert len({one["PTC"].mean for one in shown}) > 1
    for one in shown:
        for metric in SHOWN:
            value = one[metric]
            assert 0.0 <= value.low <= value.mean <= value.high <= 1.0
            assert value.mean * 5 == pytest.approx(round(value.mean * 5))  # 60 turns: steps of 0.2

"""Means and confidence intervals over episodes."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arramon_server.scoring.aggregate import ROWS, aggregate
from arramon_server.scoring.episode_scores import METRICS, EpisodeScores
from tests.work import lines


def episode(number: int, first: float, second: float, section: str = "1") -> EpisodeScores:
    return EpisodeScores(str(number), section, (dict.fromkeys(METRICS, first), dict.fromkeys(METRICS, second)))


def test_rows_are_both_turns_and_their_mean_over_all_episodes() -> None:
    table = aggregate([episode(1, 1.0, 0.0), episode(2, 1.0, 1.0), episode(3, 0.0, 0.0), episode(4, 1.0, 0.0)])
    assert tuple(table.rows) == ROWS
    assert table.episodes == 4
    for metric in METRICS:
        assert [table.rows[row][metric].mean for row in ROWS] == [0.75, 0.25, 0.5]


def test_unplayed_episodes_count_in_the_denominator() -> None:
    table = aggregate([episode(1, 1.0, 1.0), *(episode(n, 0.0, 0.0) for n in range(2, 5))])
    assert table.rows["total"]["PTC"].mean == 0.25


def test_each_metric_has_its_own_mean() -> None:
    turn = {name: float(n) for n, name in enumerate(METRICS)}
    table = aggregate([EpisodeScores("1", "1", (turn, turn))])
    assert {name: table.rows["total"][name].mean for name in METRICS} == turn


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1), st.sampled_from("123")), min_size=1, max_size=20))
def test_an_interval_holds_its_mean_and_stays_within_the_scores_range(values: list[tuple[float, float, str]]) -> None:
    table = aggregate([episode(n, *value) for n, value in enumerate(values)])
    for row in ROWS:
        interval = table.rows[row]["nDTW"]
        assert 0.0 <= interval.low <= interval.mean <= interval.high <= 1.0


def test_one_table_whatever_the_order_of_the_episodes() -> None:
    draw = random.Random(0)
    episodes = [episode(n, draw.random(), draw.random(), str(n % 3)) for n in range(50)]
    assert aggregate(episodes) == aggregate(draw.sample(episodes, len(episodes)))


def test_sections_are_taken_as_given() -> None:
    # Within a section all episodes agree, and the sections differ: drawing episodes anew in them changes nothing.
    alike = [episode(n, float(n % 2), 0.0, section=str(n % 2)) for n in range(200)]
    apart = aggregate(alike).rows["turn 1"]["PTC"]
    assert (apart.mean, apart.high - apart.low) == pytest.approx((0.5, 0.0099), abs=0.0001)
    assert apart.sections is not None
    assert (apart.sections.deviation, apart.sections.low, apart.sections.high) == pytest.approx(
        (0.7071, 0, 1), abs=0.01
    )
    alone = aggregate([episode(n, float(n % 2), 0.0) for n in range(200)]).rows["turn 1"]["PTC"]
    assert (alone.low, alone.high) == pytest.approx((0.431, 0.569), abs=0.001)
    assert alone.sections is None


def test_sections_are_weighted_by_their_episodes() -> None:
    uneven = [episode(n, float(n < 3), 0.0, "a" if n < 3 else "b") for n in range(4)]
    assert aggregate(uneven).rows["turn 1"]["PTC"].mean == 0.75


def test_sections_with_few_episodes_are_not_compared() -> None:
    few = [episode(n, float(n % 2), 0.0, section="a" if n < 9 else "b") for n in range(40)]
    assert aggregate(few).rows["turn 1"]["PTC"].sections is None
    enough = [episode(n, float(n % 2), 0.0, section="a" if n < 10 else "b") for n in range(40)]
    assert aggregate(enough).rows["turn 1"]["PTC"].sections is not None


def test_no_episodes_is_an_error() -> None:
    with pytest.raises(ValueError, match="no episodes"):
        aggregate([])


def test_a_whole_split_is_not_aggregated_episode_by_episode() -> None:
    draw = random.Random(1)
    split = [
        EpisodeScores(str(n), "1", ({m: draw.random() for m in METRICS}, {m: draw.random() for m in METRICS}))
        for n in range(1065)
    ]
    assert lines(lambda: aggregate(split)) < 100 * len(split)

"""Means and confidence intervals over episodes."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from server.scoring.aggregate import ROWS, Interval, aggregate
from server.scoring.episode import METRICS, EpisodeScores
from tests.work import lines


def episode(number: int, first: float, second: float, section: str = "1") -> EpisodeScores:
    return EpisodeScores(str(number), section, (dict.fromkeys(METRICS, first), dict.fromkeys(METRICS, second)))


def test_rows_are_the_turns_and_the_mean_of_both_over_all_episodes() -> None:
    table = aggregate([episode(1, 1.0, 0.0), episode(2, 1.0, 1.0), episode(3, 0.0, 0.0), episode(4, 1.0, 0.0)])
    assert tuple(table.rows) == ROWS
    assert table.episodes == 4
    for metric in METRICS:
        assert [table.rows[row][metric].mean for row in ROWS] == [0.75, 0.25, 0.5]


def test_what_was_not_played_stays_in_the_denominator() -> None:
    table = aggregate([episode(1, 1.0, 1.0), *(episode(n, 0.0, 0.0) for n in range(2, 5))])
    assert table.rows["total"]["PTC"].mean == 0.25


def test_each_metric_has_its_own_mean() -> None:
    turn = {name: float(n) for n, name in enumerate(METRICS)}
    table = aggregate([EpisodeScores("1", "1", (turn, turn))])
    assert {name: table.rows["total"][name].mean for name in METRICS} == turn


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1), st.sampled_from("123")), min_size=1, max_size=20),
    st.integers(0, 5),
)
def test_an_interval_holds_its_mean_and_stays_within_the_values(
    values: list[tuple[float, float, str]], seed: int
) -> None:
    table = aggregate([episode(n, *value) for n, value in enumerate(values)], resamples=100, seed=seed)
    for turn, row in enumerate(("turn 1", "turn 2")):
        held = [value[:2][turn] for value in values]
        interval = table.rows[row]["nDTW"]
        assert min(held) - 1e-12 <= interval.low <= interval.mean <= interval.high <= max(held) + 1e-12


def test_the_interval_is_the_known_one_of_a_fair_coin() -> None:
    # 400 values, half of them 1: the mean's standard error is 0.025, so that 95% spans 0.5 +- 0.049.
    interval = aggregate([episode(n, n % 2, 0.0) for n in range(400)], resamples=4000).rows["turn 1"]["PTC"]
    assert interval.low == pytest.approx(0.451, abs=0.006)
    assert interval.high == pytest.approx(0.549, abs=0.006)


def test_one_seed_gives_one_table_whatever_the_order_of_the_episodes() -> None:
    draw = random.Random(0)
    episodes = [episode(n, draw.random(), draw.random(), str(n % 3)) for n in range(50)]
    shuffled = draw.sample(episodes, len(episodes))
    assert aggregate(episodes) == aggregate(shuffled)
    one_section = [episode(n, draw.random(), 0.0) for n in range(50)]
    assert aggregate(one_section) == aggregate(one_section[::-1])
    assert aggregate(one_section) != aggregate(one_section, seed=1)


def test_equal_episodes_leave_no_interval() -> None:
    for sections in ("1", "12"):
        table = aggregate([episode(n, 0.1, 0.1, sections[n % len(sections)]) for n in range(7)])
        interval = table.rows["total"]["rPOD"]
        assert (interval.low, interval.mean, interval.high) == pytest.approx((0.1, 0.1, 0.1), abs=1e-12)


def test_a_single_episode_is_its_own_interval() -> None:
    assert aggregate([episode(1, 0.5, 0.25)]).rows["turn 2"]["nDTW"] == Interval(0.25, 0.25, 0.25)


def test_sections_are_drawn_whole() -> None:
    # Within a section all episodes agree; the sections differ. Drawn by episode, 200 of them would look precise.
    alike = [episode(n, float(n % 2), 0.0, section=str(n % 2)) for n in range(200)]
    clustered = aggregate(alike)
    assert clustered.clustered
    assert clustered.rows["turn 1"]["PTC"] == Interval(0.5, 0.0, 1.0)
    alone = aggregate([episode(n, float(n % 2), 0.0) for n in range(200)])
    assert not alone.clustered
    assert 0.4 < alone.rows["turn 1"]["PTC"].low < 0.5 < alone.rows["turn 1"]["PTC"].high < 0.6


def test_a_section_weighs_as_many_episodes_as_it_has() -> None:
    # Three episodes of one section and one of another: drawing both gives 3/4, never the mean of the sections' means.
    uneven = [
        episode(1, 1.0, 0.0, "a"),
        episode(2, 1.0, 0.0, "a"),
        episode(3, 1.0, 0.0, "a"),
        episode(4, 0.0, 0.0, "b"),
    ]
    table = aggregate(uneven, confidence=0.0)
    assert table.rows["turn 1"]["PTC"] == Interval(0.75, 0.75, 0.75)


def test_no_episodes_is_an_error() -> None:
    with pytest.raises(ValueError, match="no episodes"):
        aggregate([])


def test_a_whole_split_is_not_resampled_episode_by_episode() -> None:
    draw = random.Random(1)
    split = [
        EpisodeScores(str(n), "1", ({m: draw.random() for m in METRICS}, {m: draw.random() for m in METRICS}))
        for n in range(1065)
    ]
    assert lines(lambda: aggregate(split)) < 100 * len(split)  # there are 1000 drawings of all of them

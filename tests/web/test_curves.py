"""Charts: the coordinates that their SVGs are drawn from."""

import pytest

from arramon_server.scoring.aggregate import ROWS, Interval
from arramon_server.web import curves


def test_ctc_chart_has_points_and_bands_per_row() -> None:
    row = {"CTC-3": Interval(0.0, 0.0, 0.25), "CTC-5": Interval(0.5, 0.25, 0.75), "CTC-7": Interval(1.0, 1.0, 1.0)}
    chart = curves.ctc_chart(dict.fromkeys(ROWS, row))
    assert [(tick.at, tick.value) for tick in chart.x_ticks] == [(44, 3), (226, 5), (408, 7)]
    assert [(tick.at, round(tick.value, 3)) for tick in chart.y_ticks][::5] == [(200, 0), (12, 1)]
    assert [line.name for line in chart.lines] == ["turn 1", "turn 2", "total"]
    assert chart.lines[0].points == "44,200 226,106 408,12"
    assert chart.lines[0].band == "44,153 226,59 408,12 408,12 226,153 44,200"


@pytest.mark.parametrize(("highest", "top"), [(0.0, 0.1), (0.1, 0.1), (0.11, 0.2), (0.3, 0.5), (0.51, 1.0)])
def test_the_axis_ends_above_the_highest_interval(highest: float, top: float) -> None:
    rows = dict.fromkeys(ROWS, dict.fromkeys(("CTC-3", "CTC-5", "CTC-7"), Interval(0.0, 0.0, highest)))
    assert curves.ctc_chart(rows).y_ticks[-1].value == pytest.approx(top)


def test_open_chart_shows_the_share_of_unended_episodes() -> None:
    shares = curves.unfinished_shares([10, 30, 10, 20])
    assert shares == [(0, 1.0), (10, 0.5), (20, 0.25), (30, 0.0)]
    chart = curves.unfinished_chart(shares)
    assert [tick.value for tick in chart.x_ticks] == [0, 10, 20, 30]
    assert chart.lines[0].points == "44,12 165.3,12 165.3,106 286.7,106 286.7,153 408,153 408,200"


def test_open_chart_drops_at_once_if_all_episodes_end_together() -> None:
    assert curves.unfinished_shares([0, 0]) == [(0, 1.0), (0, 0.0)]
    assert curves.unfinished_chart(curves.unfinished_shares([0, 0])).lines[0].points == "44,12 44,12 44,200"


def test_bar_segments_add_up_to_100_percent() -> None:
    assert curves.bar_segments({"a": 1, "b": 3}) == [("a", 1, 0.0, 25.0), ("b", 3, 25.0, 75.0)]
    assert curves.bar_segments({}) == []

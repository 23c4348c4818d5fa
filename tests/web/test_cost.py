"""Seeds, and scores against costs, on the standings page."""

import re
from collections.abc import Iterator
from contextlib import closing

import pytest

from arramon_server.board.cost import Cost
from arramon_server.runs.accounts.callers import HOST
from arramon_server.web.cost_part import COSTS, cost_part
from arramon_server.web.page_texts import all_texts
from tests.web.leaderboard_site import LeaderboardSite
from tests.web.reading import Page

EN = all_texts()["en"]


@pytest.fixture(scope="module")
def costly(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LeaderboardSite]:
    backend = LeaderboardSite(tmp_path_factory.mktemp("backend"))
    with closing(backend.database):
        for number, (agent, score, seed) in enumerate(
            (("many", 0.5, "1"), ("many", 0.4, "2"), ("many", 0.6, "3"), ("free", 0.2, None), ("silent", 0.1, None))
        ):
            arguments = (("seed", seed),) if seed else ()
            thinking = (0.0, 0) if agent == "silent" else (0.7 * (number + 1), 7)
            run_id = backend.run(f"{number:032x}", score, agent=agent, arguments=arguments, thinking=thinking)
            cost = {"many": Cost(7_000_000_000, 45_000, 12.5), "free": Cost(price=0.0), "silent": None}[agent]
            backend.publisher.publish(HOST, run_id, "", cost)
        yield backend
        backend.site.close()


@pytest.mark.parametrize("language", ["en", "hi"])
@pytest.mark.parametrize(("cost", "points"), [("thinking", 2), ("parameters", 1), ("tokens", 1), ("price", 2)])
def test_plot_has_the_standings_whose_cost_is_known(
    costly: LeaderboardSite, language: str, cost: str, points: int
) -> None:
    text = costly.site.get(f"/{language}/?split=tiny&language=en&cost={cost}").text
    part = text[text.index('id="cost"') :]
    assert part.count("<circle") == points
    assert len(Page(text).all("caption")) == len(Page(text).all("table")) == 2
    for title in re.findall(r"<title>([^<]*)</title>", part):
        assert title in ("many", "free")
    rows = re.findall(r'<td class="number">([^<]*)</td><th scope="row" class="pin name"><bdi>([^<]*)</bdi>', part)
    ranks = {one.agent: f"{one.rank}{'=' if one.tied else ''}" for one in costly.board.standings("tiny", "en")}
    assert sorted(rows) == sorted((ranks[agent], agent) for agent in ("free", "many"))
    drawn = re.findall(r'<title>([^<]*)</title>.*?<text class="number"[^>]*>([^<]*)</text>', part)
    assert len(drawn) == points
    assert all(ranks[agent] == rank for agent, rank in drawn)
    assert "7×10⁹" in part
    assert "12.5" in part


def test_seeds_are_one_line_with_their_spread(costly: LeaderboardSite) -> None:
    text = costly.site.get("/en/?split=tiny&language=en").text
    (line,) = [row for row in text.split("<tr>") if "seed 2" in row]
    assert [f"seed {number}" in line for number in (1, 2, 3)] == [True] * 3
    assert "3 seeds; deviation between them 0.100" in line
    assert "over other seeds 0.252–0.748" in line
    assert line.count("/runs/") == 3


def test_unknown_cost_is_no_page(costly: LeaderboardSite) -> None:
    assert costly.site.get("/en/?split=tiny&language=en&cost=beauty").status == 404


def test_there_is_no_plot_where_no_cost_is_known(web: LeaderboardSite) -> None:
    web.published(1, 0.5, "plain")
    assert 'id="cost"' not in web.site.get("/en/?split=tiny&language=en").text


def test_axis_holds_its_points_and_has_a_place_for_0(costly: LeaderboardSite) -> None:
    lines = costly.board.standings("tiny", "en")
    for cost in COSTS:
        part = cost_part(EN, lines, "total", "PTC@CTC-3", cost)
        assert part is not None
        places = [at for at, _ in part.x_ticks]
        assert places == sorted(places)
        assert all(places[0] <= point.x <= places[-1] for point in part.points)
        assert all(point.top <= point.y <= point.bottom for point in part.points)
        assert len(part.x_ticks) <= 8
        assert ("0" in [label for _, label in part.x_ticks]) == (cost == "price")


@pytest.mark.parametrize(
    ("number", "written"),
    [
        (0.0, "0"), (0.0312, "0.0312"), (0.5, "0.5"), (12.345, "12.3"), (45_000, "45,000"), (999_499, "999,000"),
        (999_501, "10⁶"), (7e9, "7×10⁹"), (1.234e12, "1.23×10¹²"), (1e-5, "10⁻⁵"),
    ],
)  # fmt: skip
def test_amounts_have_three_digits_that_count(number: float, written: str) -> None:
    assert EN.amount(number) == written

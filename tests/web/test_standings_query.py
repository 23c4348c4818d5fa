"""A reader's choices: query parameters, sorting and filters."""

from dataclasses import replace
from urllib.parse import parse_qsl

import pytest

from arramon_server.board.ranking import ranked
from arramon_server.board.standings import Mark, Standing
from arramon_server.errors import NotFound
from arramon_server.scoring.language_gap import LanguageGap
from arramon_server.web.standings_query import StandingsQuery, read_query
from tests.board.leaderboard_backend import family, interval, standing

LANGUAGES = {"open": ("en", "hi"), "english": ("en",), "bare": ()}
USUAL = StandingsQuery("open", "hi")


@pytest.mark.parametrize(
    ("query", "choice"),
    [
        ({}, USUAL),
        ({"split": "open", "language": "both"}, StandingsQuery("open", "both")),
        ({"split": "english"}, StandingsQuery("english", "en")),
        ({"split": "english", "language": "hi"}, StandingsQuery("english", "en")),
        (
            {"turns": "2", "sort": "ndtw", "order": "asc"},
            StandingsQuery("open", "hi", turns="2", sort="ndtw", order="asc"),
        ),
        ({"sensors": "plain", "coverage": "whole"}, StandingsQuery("open", "hi", sensors="plain", coverage="whole")),
        ({"page": "3", "utm_source": "x"}, StandingsQuery("open", "hi", page=3)),
    ],
)
def test_query_parameters_are_read_as_a_choice(query: dict[str, str], choice: StandingsQuery) -> None:
    assert read_query(query, LANGUAGES, USUAL) == choice


@pytest.mark.parametrize(
    "query",
    [
        {"split": "no"},
        {"language": "fr"},
        {"turns": "3"},
        {"sensors": "rgb"},
        {"coverage": ""},
        {"sort": "PTC@CTC-3"},
        {"order": "up"},
        {"page": "0"},
        {"page": "-1"},
        {"page": "x"},
        {"page": "٣"},
        {"page": ""},
    ],
)
def test_invalid_query_parameters_are_not_found(query: dict[str, str]) -> None:
    with pytest.raises(NotFound, match="there is no"):
        read_query(query, LANGUAGES, USUAL)


def test_links_omit_default_parameters() -> None:
    choice = StandingsQuery("open", "hi", turns="1", page=4)
    assert choice.link() == "?split=open&language=hi&turns=1"
    assert choice.link(page=2, turns="total") == "?split=open&language=hi&page=2"
    assert StandingsQuery("a b&c", "en").link() == "?split=a+b%26c&language=en"


def test_column_links_sort_best_first_then_reversed() -> None:
    choice = StandingsQuery("open", "hi")
    assert choice.sorting("ndtw") == "?split=open&language=hi&sort=ndtw"
    assert choice.sorting("agent") == "?split=open&language=hi&sort=agent"
    assert choice.sorting("ptc") == "?split=open&language=hi&order=asc"
    assert StandingsQuery("open", "hi", order="asc").sorting("ptc") == "?split=open&language=hi"


def lines() -> list[Standing]:
    """Three that are ranked and one that is not, though its scores are the best."""
    return [
        standing("low", {"PTC@CTC-3": interval(0.1), "nDTW": interval(0.9)}, published=3),
        standing("high", {"PTC@CTC-3": interval(0.9), "nDTW": interval(0.1)}, published=1),
        standing("Middle", {"PTC@CTC-3": interval(0.5), "nDTW": interval(0.5)}, published=2),
        standing("apart", {"PTC@CTC-3": interval(1.0)}, marks=(Mark.PARTIAL,), coverage=0.5, published=4),
    ]


@pytest.mark.parametrize(
    ("sort", "order", "agents"),
    [
        ("ptc", "desc", ["high", "Middle", "low", "apart"]),
        ("ptc", "asc", ["low", "Middle", "high", "apart"]),
        ("ndtw", "desc", ["low", "Middle", "high", "apart"]),
        ("agent", "asc", ["apart", "high", "low", "Middle"]),
        ("agent", "desc", ["Middle", "low", "high", "apart"]),
        ("published", "desc", ["apart", "low", "Middle", "high"]),
        ("published", "asc", ["high", "Middle", "low", "apart"]),
    ],
)
def test_standings_are_sorted_by_the_chosen_column(sort: str, order: str, agents: list[str]) -> None:
    choice = StandingsQuery("open", "en", sort=sort, order=order)
    standings = lines()
    tests = family(standings, {one.agent: [one.rows["total"][choice.metric].mean] * 20 for one in standings})
    assert [one.agent for one in choice.sorted(ranked(standings, choice.metric, tests))] == agents


def test_standings_can_be_sorted_by_one_turn() -> None:
    first = standing("first", {"PTC@CTC-3": interval(0.9)})
    second = standing("second", {"PTC@CTC-3": interval(0.1)})
    better = {**second.rows, "turn 2": {**second.rows["turn 2"], "PTC@CTC-3": interval(0.7)}}
    second = Standing(second.entries, better)
    ordered = ranked([first, second], "PTC@CTC-3", family([first, second], {"first": [0.9], "second": [0.1]}))
    assert [one.agent for one in StandingsQuery("open", "en").sorted(ordered)] == ["first", "second"]
    assert [one.agent for one in StandingsQuery("open", "en", turns="2").sorted(ordered)] == ["second", "first"]
    assert [one.agent for one in StandingsQuery("open", "en", turns="2", order="asc").sorted(ordered)] == [
        "first",
        "second",
    ]


def test_coverage_and_sensor_filters_select_standings() -> None:
    plain, partial = lines()[0], lines()[3]
    assert [StandingsQuery("open", "en", coverage=c).fits(plain) for c in ("all", "whole", "partial")] == [
        True,
        True,
        False,
    ]
    assert [StandingsQuery("open", "en", coverage=c).fits(partial) for c in ("all", "whole", "partial")] == [
        True,
        False,
        True,
    ]
    assert [
        StandingsQuery("open", "en", sensors=s).fits(plain) for s in ("all", "plain", "segmentation", "privileged")
    ] == [
        True,
        True,
        False,
        False,
    ]


def test_the_smallest_gap_at_a_least_score() -> None:
    def one(name: str, score: float, mean: float | None) -> Standing:
        gap = None if mean is None else LanguageGap("en", "hi", mean, 0.0, 1.0, 0.5, 6)
        return replace(standing(name, {"PTC@CTC-3": interval(score)}), gap=gap)

    standings = [one("wide", 0.9, 0.3), one("none", 0.8, None), one("narrow", 0.5, 0.1), one("idle", 0.0, 0.0)]
    choice = StandingsQuery("open", "both", sort="gap", order="asc")
    assert [line.agent for line in choice.sorted(standings)] == ["idle", "narrow", "wide", "none"]
    least = replace(choice, least="0.5")
    assert [line.agent for line in standings if least.fits(line)] == ["wide", "none", "narrow"]
    assert StandingsQuery("open", "both").sorting("gap").endswith("&sort=gap")


@pytest.mark.parametrize(
    ("query", "order"),
    [({}, "desc"), ({"sort": "gap"}, "asc"), ({"sort": "agent"}, "asc"), ({"sort": "gap", "order": "desc"}, "desc")],
)
def test_each_column_has_an_order_of_its_own_at_first(query: dict[str, str], order: str) -> None:
    choice = read_query(query, {"open": ("en", "hi")}, StandingsQuery("open", "en"))
    assert choice.order == order
    assert choice.is_reversed == ("order" in query) == ("order=" in choice.link())
    assert (
        read_query(dict(parse_qsl(choice.link()[1:])), {"open": ("en", "hi")}, StandingsQuery("open", "en")) == choice
    )


@pytest.mark.parametrize(("text", "allowed"), [("", True), ("0.2", True), (".25", True), ("1", True), ("0", True),
    ("2", False), ("-0.1", False), ("nan", False), ("1e-3", False), ("0.1.1", False), ("٠.٢", False)])  # fmt: skip
def test_least_scores(text: str, allowed: bool) -> None:
    languages, defaults = {"open": ("en", "hi")}, StandingsQuery("open", "en")
    if allowed:
        assert read_query({"least": text}, languages, defaults).least == text
    else:
        with pytest.raises(NotFound):
            read_query({"least": text}, languages, defaults)

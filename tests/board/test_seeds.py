"""Standings of several runs that differ in their seed, and declared costs."""

import csv
import io
import json
import math

import pytest

from arramon_server.board.cost import Cost
from arramon_server.board.exports import as_csv, as_json
from arramon_server.board.standings import BOTH
from arramon_server.errors import BadInput
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.storage.records import CodeReference
from tests.board.leaderboard_backend import LeaderboardBackend

FIRST, SECOND, THIRD = [1.0, 1.0, 0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 0.0, 0.0, 1.0, 1.0], [1.0, 1.0, 0.0, 0.0, 0.0, 1.0]


def seeded(backend: LeaderboardBackend, run_id: str, scores: list[float], seed: str | None, **more: str) -> str:
    arguments = (("beam", more.pop("beam", "4")), *((("seed", seed),) if seed is not None else ()))
    return backend.publish(backend.run(run_id, scores, arguments=arguments, **more))  # type: ignore[arg-type]


def test_runs_with_other_seeds_form_one_standing(backend: LeaderboardBackend) -> None:
    seeded(backend, "b", SECOND, "10")
    seeded(backend, "a", FIRST, "9")
    seeded(backend, "c", THIRD, None)  # with the agent's own seed
    (line,) = backend.board.standings("tiny", "en")
    assert [entry.run.run_id for entry in line.entries] == ["c", "a", "b"]
    assert (line.seeds, line.languages, line.rank, line.attempts.begun) == (3, ("en",), 1, 3)
    assert line.rows["total"]["PTC@CTC-3"].mean == pytest.approx((4 + 3 + 3) / 18)
    assert line.spread is not None
    assert (line.spread.runs, line.spread.deviation) == (3, 0.0)
    assert line.spread.rest_deviation is not None
    assert line.spread.rest_deviation > 0.2
    for run_id in "abc":
        assert backend.board.compare_with_all(run_id).standing is line


def test_runs_that_differ_in_more_than_their_seed_stand_apart(backend: LeaderboardBackend) -> None:
    seeded(backend, "a", FIRST, "1")
    seeded(backend, "b", FIRST, "2", beam="5")
    seeded(backend, "c", FIRST, "3", agent="other")
    seeded(backend, "d", FIRST, "4", participant="rival")
    backend.publish(
        backend.run("e", FIRST, arguments=(("beam", "4"), ("seed", "5")), code=CodeReference(commit="0" * 40))
    )
    lines = backend.board.standings("tiny", "en")
    assert sorted(len(line.entries) for line in lines) == [1, 1, 1, 1, 1]
    assert all(line.spread is None for line in lines)


def test_of_one_seed_the_latest_counts_and_others_stand_alone(backend: LeaderboardBackend) -> None:
    seeded(backend, "a", FIRST, "1")
    seeded(backend, "b", SECOND, "1")
    seeded(backend, "c", THIRD, "2")
    lines = backend.board.standings("tiny", "en")
    assert sorted([entry.run.run_id for entry in line.entries] for line in lines) == [["a"], ["b", "c"]]
    assert len(backend.board.standings("tiny", "en", "nDTW")) == 2


def test_runs_without_seeds_stand_alone(backend: LeaderboardBackend) -> None:
    seeded(backend, "a", FIRST, None)
    seeded(backend, "b", SECOND, None)
    assert [len(line.entries) for line in backend.board.standings("tiny", "en")] == [1, 1]


def test_parts_of_a_split_stand_alone(backend: LeaderboardBackend) -> None:
    seeded(backend, "a", FIRST, "1")
    seeded(backend, "b", SECOND[:3], "2")
    assert [len(line.entries) for line in backend.board.standings("tiny", "en")] == [1, 1]


def test_languages_and_seeds_are_joined(backend: LeaderboardBackend) -> None:
    """The tiny split has four of its six episodes in Hindi."""
    for number, (english, hindi) in enumerate(((FIRST, [1.0] * 4), (SECOND, [0.0] * 4)), start=1):
        seeded(backend, f"e{number}", english, str(number))
        seeded(backend, f"h{number}", hindi, str(number), language="hi")
    (line,) = backend.board.combined_standings("tiny")
    assert [entry.run.run_id for entry in line.entries] == ["e1", "e2", "h1", "h2"]
    assert (line.languages, line.seeds) == (("en", "hi"), 2)
    assert line.rows["total"]["nDTW"].mean == pytest.approx(((4 + 3) / 12 + 0.5) / 2)
    assert line.gap is not None
    assert line.spread is not None
    assert line.spread.runs == 2
    seeded(backend, "e3", THIRD, "3")  # a seed that Hindi has not
    (line,) = backend.board.combined_standings("tiny")
    assert (line.seeds, line.spread) == (2, None)


def test_pairs_are_compared_by_the_mean_over_seeds(backend: LeaderboardBackend) -> None:
    seeded(backend, "a", [1.0] * 6, "1")
    seeded(backend, "b", [0.0] * 6, "2")
    seeded(backend, "c", [0.0] * 6, None, agent="other")
    ((other, compared),) = backend.board.compare_with_all("a").lines
    assert other.agent == "other"
    assert compared.difference.mean == pytest.approx(0.5)


def test_small_hidden_split_shows_no_spread(backend: LeaderboardBackend) -> None:
    """Three episodes: the spread would tell of single ones."""
    seeded(backend, "a", [1.0, 0.0, 1.0], "1", split="secret")
    seeded(backend, "b", [1.0, 0.0, 0.0], "2", split="secret")
    (line,) = backend.board.standings("secret", "en")
    assert (line.seeds, line.spread) == (2, None)


def test_cost_is_kept_until_another_is_declared(backend: LeaderboardBackend) -> None:
    backend.run("a")
    backend.publisher.publish(HOST, "a", "", Cost(parameters=7_000_000_000, price=12.5))
    backend.publisher.publish(HOST, "a", "a note")
    assert backend.board.entry("a").cost == Cost(7_000_000_000, None, 12.5)
    backend.publisher.publish(HOST, "a", "", Cost(tokens=3))
    assert backend.board.entry("a").cost == Cost(None, 3, None)
    (line,) = json.loads(as_json(backend.board.listing("tiny", "en")))["standings"]
    assert line["declared_cost"] == {"parameters": None, "tokens": 3, "price": None}
    cells = next(csv.DictReader(io.StringIO(as_csv(backend.board.listing("tiny", "en")))))
    assert [cells[f"declared {name}"] for name in ("parameters", "tokens", "price")] == ["", "3", ""]
    assert (cells["seeds"], cells["seed deviation"], cells["seconds a step"]) == ("1", "", "")


def test_cost_of_several_runs_is_the_mean_of_those_declared(backend: LeaderboardBackend) -> None:
    for run_id, seed, cost in (("a", "1", Cost(price=1.0, tokens=10)), ("b", "2", Cost(price=2.0))):
        backend.run(run_id, FIRST, arguments=(("seed", seed),))
        backend.publisher.publish(HOST, run_id, "", cost)
    (line,) = backend.board.standings("tiny", "en")
    assert line.cost == Cost(None, 10, 1.5)


@pytest.mark.parametrize("cost", [Cost(price=-1.0), Cost(price=math.inf), Cost(price=math.nan), Cost(tokens=10**19)])
def test_impossible_cost_is_refused(backend: LeaderboardBackend, cost: Cost) -> None:
    backend.run("a")
    with pytest.raises(BadInput, match=r"the declared (price|tokens) is .*; expected a number from 0 to 1e\+18"):
        backend.publisher.publish(HOST, "a", "", cost)


def test_time_for_an_answer_is_the_mean_over_all_steps(backend: LeaderboardBackend) -> None:
    for run_id, seed, seconds in (("a", "1", 0.5), ("b", "2", 1.5)):
        backend.publish(backend.run(run_id, FIRST, arguments=(("seed", seed),), thinking=(seconds * 7, 7)))
    (line,) = backend.board.standings("tiny", "en")
    assert line.seconds_a_step == pytest.approx(1.0)
    assert backend.board.entry("a").progress.seconds_a_step == pytest.approx(0.5)
    assert backend.board.standings("tiny", BOTH) == []

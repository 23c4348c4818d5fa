"""Order, ranks and ties of standings with literal numbers."""

from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from arramon_server.board.comparisons import transitive_closure
from arramon_server.board.ranking import ranked
from arramon_server.board.standings import HEADLINE, Mark, Standing
from tests.board.leaderboard_backend import family, interval, standing

Scores = Mapping[str, Sequence[float]]
"""An agent's score in each episode, by name."""


def placed(scores: Scores, **marks: Mark) -> list[Standing]:
    """Return the standings of agents with these scores in PTC."""
    lines = [
        standing(name, {HEADLINE: interval(sum(of) / len(of))}, marks=(marks[name],) if name in marks else ())
        for name, of in scores.items()
    ]
    return ranked(lines, HEADLINE, family(lines, scores))


EASY, HARD = [1.0] * 20 + [0.0] * 20, [0.0] * 20 + [1.0] * 20


@pytest.mark.parametrize(
    ("scores", "expected"),
    [
        ({}, []),
        ({"a": [0.5]}, [("a", 1, 1, False)]),
        # Better in each of 40 episodes, by however little.
        ({"b": [0.2] * 40, "a": [0.21] * 40}, [("a", 1, 1, False), ("b", 2, 2, False)]),
        # Ten times the difference, but the other way round in half of the episodes.
        ({"b": EASY, "a": [0.1 + 0.9 * score for score in HARD]}, [("a", 1, 2, True), ("b", 1, 2, True)]),
        # Equal in each episode.
        ({"a": EASY, "b": EASY}, [("a", 1, 2, True), ("b", 1, 2, True)]),
        # Four episodes cannot show a difference, as two runs that are equal differ so once in eight times.
        ({"a": [1.0] * 4, "b": [0.0] * 4}, [("a", 1, 2, True), ("b", 1, 2, True)]),
        # Six can, if they are the only pair.
        ({"a": [1.0] * 6, "b": [0.0] * 6}, [("a", 1, 1, False), ("b", 2, 2, False)]),
        (
            {"a": [1.0] * 6, "b": [0.5] * 6, "c": [0.0] * 6},
            [("a", 1, 3, True), ("b", 1, 3, True), ("c", 1, 3, True)],
        ),
        # b varies too much to differ from either; a and c differ, so that one run is shown to be better than c.
        (
            {"a": [0.2] * 40, "b": [0.15 + 0.4 * (-1) ** n for n in range(40)], "c": [0.1] * 40},
            [("a", 1, 2, True), ("b", 1, 3, True), ("c", 2, 3, False)],
        ),
    ],
)
def test_overlapping_intervals_share_a_rank(scores: Scores, expected: list[tuple[str, int, int, bool]]) -> None:
    assert [(line.agent, line.rank, line.last_rank, line.tied) for line in placed(scores)] == expected


def test_who_beats_a_winner_beats_whom_the_winner_beats() -> None:
    # a beats b in nearly all episodes, and b beats c in nearly all; a and c are compared over very uneven differences.
    better = np.array([[False, True, False], [False, False, True], [False, False, False]])
    assert transitive_closure(better).tolist() == [[False, True, True], [False, False, True], [False, False, False]]
    assert transitive_closure(np.eye(4, k=1, dtype=bool)).tolist() == np.triu(np.ones((4, 4), bool), 1).tolist()


def test_ranks_ascend_although_means_need_not() -> None:
    # b is a little worse than a everywhere, which is shown; c is worse still, and varies too much to show it.
    scores = {
        "a": [0.50] * 40,
        "b": [0.49] * 40,
        "c": [1.0 if n % 5 < 2 else 0.1 for n in range(40)],
    }
    assert [(line.agent, line.rank) for line in placed(scores)] == [("a", 1), ("c", 1), ("b", 2)]


def test_standings_are_ranked_by_the_requested_metric() -> None:
    lines = [
        standing("placer", {"PTC@CTC-3": interval(0.5), "nDTW": interval(0.1)}),
        standing("walker", {"PTC@CTC-3": interval(0.1), "nDTW": interval(0.5)}),
    ]
    for metric, first, second in (("PTC@CTC-3", "placer", "walker"), ("nDTW", "walker", "placer")):
        tests = family(lines, {first: [0.5] * 6, second: [0.1] * 6})
        assert [(line.agent, line.rank) for line in ranked(lines, metric, tests)] == [(first, 1), (second, 2)]


def test_equal_means_are_ordered_by_further_metrics_then_by_time() -> None:
    lines = [
        standing("late", {}, published=2),
        standing("early", {}, published=1),
        standing("walks", {"nDTW": interval(0.5)}, published=3),
        standing("finds", {"CTC-3": interval(0.1)}, published=3),
        standing("puts", {"rPOD@CTC-3": interval(0.1)}, published=3),
    ]
    equal = dict.fromkeys([line.agent for line in lines], [0.5] * 6)
    placed = ranked(lines, HEADLINE, family(lines, equal))
    assert [line.agent for line in placed] == ["puts", "finds", "walks", "early", "late"]
    assert {(line.rank, line.tied) for line in placed} == {(1, True)}


@pytest.mark.parametrize(
    ("mark", "expected"),
    [
        (Mark.PARTIAL, [("plain", 1), ("marked", 0)]),
        (Mark.PRIVILEGED, [("plain", 1), ("marked", 0)]),
        (Mark.OTHER_DATA, [("plain", 1), ("marked", 0)]),
        (Mark.OTHER_LIMITS, [("plain", 1), ("marked", 0)]),
        (Mark.SERVER_FAULT, [("marked", 1), ("plain", 2)]),
    ],
)
def test_incomparable_runs_are_listed_last_and_unranked(mark: Mark, expected: list[tuple[str, int]]) -> None:
    lines = placed({"marked": [0.9] * 6, "plain": [0.1] * 6}, marked=mark)
    assert [(line.agent, line.rank) for line in lines] == expected


def test_unranked_standings_are_never_tied() -> None:
    lines = placed({"plain": [0.5] * 6, "part": [0.5] * 6}, part=Mark.PARTIAL)
    assert [(line.agent, line.tied, line.last_rank) for line in lines] == [("plain", False, 1), ("part", False, 0)]

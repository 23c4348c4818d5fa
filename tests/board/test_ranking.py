"""Order, ranks and ties of standings with literal numbers."""

import pytest

from server.board.ranking import ranked
from server.board.standings import HEADLINE, Mark
from tests.board.made import interval, standing

Line = tuple[str, float, float]
"""A name, its mean in PTC, and half of its interval."""


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ([], []),
        ([("a", 0.5, 0.1)], [("a", 1, False)]),
        # Apart from each other.
        ([("b", 0.2, 0.05), ("a", 0.8, 0.05), ("c", 0.5, 0.05)], [("a", 1, False), ("c", 2, False), ("b", 3, False)]),
        # Two at the top overlap, the third does not.
        ([("a", 0.8, 0.05), ("b", 0.75, 0.05), ("c", 0.5, 0.05)], [("a", 1, True), ("b", 1, True), ("c", 3, False)]),
        # Ends that touch overlap.
        ([("a", 0.75, 0.125), ("b", 0.5, 0.125)], [("a", 1, True), ("b", 1, True)]),
        # c overlaps with b, not with a, which leads the group: a new group.
        ([("a", 0.8, 0.1), ("b", 0.7, 0.1), ("c", 0.6, 0.05)], [("a", 1, True), ("b", 1, True), ("c", 3, False)]),
        # d overlaps with c, the leader of the second group.
        (
            [("a", 0.8, 0.1), ("b", 0.7, 0.1), ("c", 0.6, 0.05), ("d", 0.56, 0.01)],
            [("a", 1, True), ("b", 1, True), ("c", 3, True), ("d", 3, True)],
        ),
        # A wide one below a narrow one that is apart: it is compared with the leader of the group before it.
        ([("a", 0.8, 0.01), ("b", 0.6, 0.01), ("c", 0.5, 0.4)], [("a", 1, False), ("b", 2, True), ("c", 2, True)]),
    ],
)
def test_ranks_and_ties(lines: list[Line], expected: list[tuple[str, int, bool]]) -> None:
    standings = [standing(name, {HEADLINE: interval(mean, half)}) for name, mean, half in lines]
    assert [(line.agent, line.rank, line.tied) for line in ranked(standings, HEADLINE)] == expected


def test_the_metric_asked_for_orders_and_ranks() -> None:
    lines = [
        standing("placer", {"PTC@CTC-3": interval(0.5), "nDTW": interval(0.1)}),
        standing("walker", {"PTC@CTC-3": interval(0.1), "nDTW": interval(0.5)}),
    ]
    assert [(line.agent, line.rank) for line in ranked(lines, "PTC@CTC-3")] == [("placer", 1), ("walker", 2)]
    assert [(line.agent, line.rank) for line in ranked(lines, "nDTW")] == [("walker", 1), ("placer", 2)]


def test_equal_means_are_ordered_by_the_next_column_and_at_last_by_time() -> None:
    lines = [
        standing("late", {}, published=2),
        standing("early", {}, published=1),
        standing("walks", {"nDTW": interval(0.5)}, published=3),
        standing("finds", {"CTC-3": interval(0.1)}, published=3),
        standing("puts", {"rPOD@CTC-3": interval(0.1)}, published=3),
    ]
    placed = ranked(lines, HEADLINE)
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
def test_what_cannot_be_compared_is_listed_last_and_not_ranked(mark: Mark, expected: list[tuple[str, int]]) -> None:
    lines = [
        standing("marked", {HEADLINE: interval(0.9)}, marks=(mark,)),
        standing("plain", {HEADLINE: interval(0.1)}),
    ]
    assert [(line.agent, line.rank) for line in ranked(lines, HEADLINE)] == expected


def test_unranked_standings_are_never_tied() -> None:
    lines = [
        standing("plain", {HEADLINE: interval(0.5, 0.2)}),
        standing("part", {HEADLINE: interval(0.5, 0.2)}, marks=(Mark.PARTIAL,)),
    ]
    assert [(line.agent, line.tied) for line in ranked(lines, HEADLINE)] == [("plain", False), ("part", False)]

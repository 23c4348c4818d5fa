"""A* over states of any kind, shared by the agents that plan their motion."""

from collections.abc import Hashable, Iterable
from heapq import heappop, heappush
from typing import Generic, NamedTuple, Protocol, TypeVar

State = TypeVar("State")


class SearchProblem(Protocol[State]):
    """What is searched: states, the moves between them, and the goal."""

    def key(self, state: State) -> Hashable:
        """Return what identifies a state; states with the same key count as one."""

    def successors(self, state: State) -> Iterable[tuple[State, float]]:
        """Return the states that one move leads to, with the cost of that move, at least 0."""

    def remaining(self, state: State) -> float:
        """Return an estimate of the cost from a state to the goal."""

    def is_goal(self, state: State) -> bool:
        """Return whether a state is a goal."""


class SearchResult(NamedTuple, Generic[State]):
    """Result of a search.

    Attributes:
        states: from the start to the last state, both included.
        reached: whether the last state is a goal; if not, it is the one with the lowest estimate that was found.
    """

    states: list[State]
    reached: bool


def a_star(
    problem: SearchProblem[State], start: State, max_expanded: int, *, margin: float = 0.0
) -> SearchResult[State]:
    """Return the path with the lowest cost, as far as the estimates are not too high.

    Args:
        problem: what is searched.
        start: the first state.
        max_expanded: number of states expanded before the search ends without a goal.
        margin: how much lower an estimate must be to replace the nearest state found so far.
    """
    states, before, costs = [start], [-1], [0.0]
    nearest, nearest_left = 0, problem.remaining(start)
    queue = [(nearest_left, 0)]
    closed: set[Hashable] = set()
    while queue and len(closed) < max_expanded:
        _, number = heappop(queue)
        state = states[number]
        key = problem.key(state)
        if key in closed:
            continue
        closed.add(key)
        if problem.is_goal(state):
            return SearchResult(_trace(states, before, number), reached=True)
        left = problem.remaining(state)
        if left < nearest_left - margin:
            nearest, nearest_left = number, left
        for new, cost in problem.successors(state):
            if problem.key(new) not in closed:
                queued = costs[number] + cost
                states.append(new)
                before.append(number)
                costs.append(queued)
                heappush(queue, (queued + problem.remaining(new), len(states) - 1))
    return SearchResult(_trace(states, before, nearest), reached=False)


def _trace(states: list[State], before: list[int], number: int) -> list[State]:
    path = []
    while number >= 0:
        path.append(states[number])
        number = before[number]
    return path[::-1]

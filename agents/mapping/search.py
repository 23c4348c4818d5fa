"""A* search over any kind of states, for all agents that plan paths."""

from collections.abc import Hashable, Iterable
from heapq import heappop, heappush
from typing import Generic, NamedTuple, Protocol, TypeVar

State = TypeVar("State")


class SearchProblem(Protocol[State]):
    """Interface of a search problem: states, moves between them, and the goal."""

    def key(self, state: State) -> Hashable:
        """Return the key of a state; states with equal keys are the same state."""

    def successors(self, state: State) -> Iterable[tuple[State, float]]:
        """Return the states that are one move away, with the cost of the move, at least 0."""

    def remaining(self, state: State) -> float:
        """Return the estimated cost from a state to the goal (the heuristic)."""

    def is_goal(self, state: State) -> bool:
        """Return whether a state is a goal."""


class SearchResult(NamedTuple, Generic[State]):
    """Result of a search.

    Attributes:
        states: path from the start to the last state, both included.
        reached: whether the last state is a goal; otherwise it is the state with the lowest heuristic found.
    """

    states: list[State]
    reached: bool


def a_star(problem: SearchProblem[State], start: State, max_expanded: int) -> SearchResult[State]:
    """Search for a path with the lowest cost; it is optimal if the heuristic never overestimates.

    Args:
        problem: the search problem.
        start: the initial state.
        max_expanded: number of states to expand before giving up.
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
        if left < nearest_left:
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

"""Turns from one heading to another."""

import pytest

from arramon_agents.mapping.motion import turns
from arramon_client.agent import Action

LEFT, RIGHT = Action.LEFT, Action.RIGHT


@pytest.mark.parametrize(
    ("heading", "to", "expected"),
    [(0, 0, []), (3, 4, [RIGHT]), (0, 11, [LEFT]), (11, 1, [RIGHT] * 2), (0, 6, [RIGHT] * 6), (0, 8, [LEFT] * 4)],
)
def test_turns_are_the_shortest(heading: int, to: int, expected: list[Action]) -> None:
    assert turns(heading, to) == expected

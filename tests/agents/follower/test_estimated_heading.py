"""Directions of turn 2 as they were meant: from where the reference ended turn 1."""

import pytest

from arramon_agents.follower.agent import make_estimating_navigator, make_rule_navigator
from arramon_agents.mapping.agent import PhasePlayer
from arramon_agents.mapping.body import AgentBody
from arramon_client.agent import Action
from arramon_client.world import HEADINGS
from arramon_dataset.trial import AGENT_LABELS
from arramon_lang.meaning import Navigation, Rotate, Thing, Walk
from tests.agents.follower.test_reference_walk import town

LEFT = Navigation((Rotate("left"), Walk("ahead", count=3)), Thing("mug", "red", "striped"))
TURNING = {Action.LEFT: -1, Action.RIGHT: 1}
EAST_STREET = 12.5, 17.4
"""An object in the street to the right, where the reference ends in heading 3."""


def body_in_town(heading: int, taken: tuple[float, float] | None) -> AgentBody:
    """The agent at its start, where it knows the town, after it has taken an object."""
    body = AgentBody(AGENT_LABELS)
    body.ground, body.heading, body.taken = town(), heading, taken
    return body


def turned(player: PhasePlayer, body: AgentBody) -> list[Action]:
    """What the agent does until the first step, a turn, is done."""
    actions: list[Action] = []
    for _ in range(2 * HEADINGS):
        action = player.act(100)
        if player.intent().get("step") != 1:
            break
        actions.append(action)
        body.heading = (body.heading + TURNING[action]) % HEADINGS
    return actions


@pytest.mark.parametrize(
    ("turn", "heading", "taken", "actions"),
    [
        (2, 2, EAST_STREET, [Action.RIGHT] + [Action.LEFT] * 3),
        (2, 3, EAST_STREET, [Action.LEFT] * 3),
        (2, 5, EAST_STREET, [Action.LEFT] * 5),
        (2, 2, None, [Action.LEFT] * 3),  # It took nothing.
        (2, 2, (70.0, 70.0), [Action.LEFT] * 3),  # It knows no way there.
        (1, 2, EAST_STREET, [Action.LEFT] * 3),
    ],
)
def test_turn_2_is_followed_from_the_estimate(
    turn: int, heading: int, taken: tuple[float, float] | None, actions: list[Action]
) -> None:
    body = body_in_town(heading, taken)
    assert turned(make_estimating_navigator(body, LEFT, turn), body) == actions


def test_rules_without_the_estimate_start_from_their_own_heading() -> None:
    body = body_in_town(2, EAST_STREET)
    assert turned(make_rule_navigator(body, LEFT, 2), body) == [Action.LEFT] * 3

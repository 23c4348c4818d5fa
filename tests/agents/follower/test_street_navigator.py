"""Directions as they were meant: along the streets, and from where the reference ended the turn before."""

import pytest

from arramon_agents.follower.agent import make_rule_navigator
from arramon_agents.follower.navigation import Navigator
from arramon_agents.follower.street_navigator import StreetNavigator, make_street_navigator
from arramon_agents.mapping.agent import PhasePlayer
from arramon_agents.mapping.body import AgentBody
from arramon_client.agent import Action
from arramon_client.world import HEADINGS
from arramon_dataset.trial import AGENT_LABELS
from arramon_lang.meaning import Navigation, Rotate, Thing, Walk
from tests.agents.follower.test_reference_walk import town

MUG, AHEAD = Thing("mug", "red", "striped"), Walk("ahead", count=3)
TURNING = {Action.LEFT: -1, Action.RIGHT: 1}


def body_in_town(heading: int, turned: int = 0) -> AgentBody:
    """The agent at its start in the town, at a heading, where it knows the streets."""
    body = AgentBody(AGENT_LABELS)
    body.ground, body.heading = town(turned), heading
    return body


def heading_after(player: PhasePlayer, body: AgentBody) -> int:
    """The agent's heading when the instruction's first step, a turn, is done."""
    for _ in range(2 * HEADINGS):
        action = player.act(100)
        if player.intent().get("step") != 1:
            break
        body.heading = (body.heading + TURNING[action]) % HEADINGS
    return body.heading


@pytest.mark.parametrize(
    ("turned", "heading", "direction", "after", "usually"),
    [
        (0, 0, "left", 9, 9),
        (0, 1, "left", 9, 10),
        (0, 11, "left", 9, 8),
        (0, 11, "right", 3, 2),
        (0, 5, "around", 0, 11),
        (0, 1, "slightly left", 0, 0),
        (0, 11, "slightly left", 10, 10),
        (1, 0, "right", 4, 3),
        (2, 3, "left", 11, 0),
    ],
)
def test_turns_lead_into_streets(turned: int, heading: int, direction: str, after: int, usually: int) -> None:
    meaning = Navigation((Rotate(direction), AHEAD), MUG)
    body = body_in_town(heading, turned)
    assert heading_after(StreetNavigator(body, meaning), body) == after
    body = body_in_town(heading, turned)
    assert heading_after(Navigator(body, meaning), body) == usually


@pytest.mark.parametrize(
    ("turn", "taken", "first"),
    [
        (2, (12.5, 17.4), [Action.RIGHT] * 3 + [Action.LEFT] * 3),  # to the reference's heading; left from there
        (2, None, [Action.LEFT] * 3),
        (2, (70.0, 70.0), [Action.LEFT] * 3),  # no way to the object is known
        (1, (12.5, 17.4), [Action.LEFT] * 3),
    ],
)
def test_second_turn_is_meant_from_the_end_of_the_reference(
    turn: int, taken: tuple[float, float] | None, first: list[Action]
) -> None:
    body = body_in_town(0)
    body.taken = taken
    player, actions = make_street_navigator(body, Navigation((Rotate("left"), AHEAD), MUG), turn), []
    for _ in first:
        actions.append(player.act(100))
        body.heading = (body.heading + TURNING[actions[-1]]) % HEADINGS
    assert actions == first


def test_rules_without_streets_do_not_look_at_what_was_taken() -> None:
    body = body_in_town(0)
    body.taken = 12.5, 17.4
    assert heading_after(make_rule_navigator(body, Navigation((Rotate("left"), AHEAD), MUG), 2), body) == 9

"""The follower: parses instructions by the grammar, and navigates and places by rules, from depth and segmentation."""

import arramon_lang as lang
from arramon_agents.follower.navigation import Navigator
from arramon_agents.follower.reference_walk import last_heading
from arramon_agents.mapping.agent import MapAgent, PhasePlayer, Skills
from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.room_player import find_by_rules
from arramon_agents.perception.percept import perceive_as_given
from arramon_lang.meaning import Assembly, Navigation, Thing


class Agent(MapAgent):
    """Rule-based agent that uses text, depth and segmentation only.

    Args:
        estimate_heading: whether to follow turn 2 from an estimate of the heading in which the reference ended turn 1,
            as `agents.seeing_follower` does. Off by default: the follower without it filters generated data, whose
            episodes would change.
    """

    name = "follower"
    sensors = ("depth", "segmentation")

    def __init__(self, *, estimate_heading: bool = False) -> None:
        super().__init__(
            Skills(
                perceive=perceive_as_given,
                read=parse_instruction,
                make_walk=make_estimating_navigator if estimate_heading else make_rule_navigator,
                find_cell=find_by_rules,
                notes=True,
            )
        )


def make_rule_navigator(body: AgentBody, meaning: Navigation, turn: int) -> PhasePlayer:  # noqa: ARG001 - both turns are alike
    """Return the player of a navigation phase by rules."""
    return Navigator(body, meaning)


def make_estimating_navigator(body: AgentBody, meaning: Navigation, turn: int) -> PhasePlayer:
    """Return the player of a navigation phase by rules, which follows turn 2 from where the reference ended turn 1.

    The reference's last heading is estimated from the object that the agent took in turn 1. If it took none, or its map
    shows no way to the object, the agent's own heading counts.
    """
    taken = body.taken if turn > 1 else None
    return Navigator(body, meaning, None if taken is None else last_heading(body.ground, taken))


def parse_instruction(language: str, text: str, phase: str) -> Navigation | Assembly:
    """Return the meaning of an instruction; if it cannot be parsed, only the object that it mentions."""
    speech = lang.load(language)
    try:
        return speech.read(text, phase)
    except lang.CannotRead:
        mentions = speech.find_objects(text)
        thing = Thing(mentions[0].kind or "", mentions[0].colour or "", mentions[0].pattern or "") if mentions else None
        if phase == "navigation":
            return Navigation((), thing or Thing(""))
        return Assembly((), thing or Thing(""), ())

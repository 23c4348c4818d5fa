"""The follower: parses instructions by the grammar, and navigates and places by rules, from depth and segmentation."""

import arramon_lang as lang
from arramon_agents.follower.navigation import Navigator
from arramon_agents.follower.street_navigator import make_street_navigator
from arramon_agents.mapping.agent import MapAgent, PhasePlayer, Skills
from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.room_player import find_by_rules
from arramon_agents.perception.percept import perceive_as_given
from arramon_lang.meaning import Assembly, Navigation, Thing


class Agent(MapAgent):
    """Rule-based agent that uses text, depth and segmentation only.

    Args:
        streets: whether to take directions as they were meant, by the streets on the map and an estimate of where the
            reference ended turn 1, as `agents.seeing_follower` does. Off by default: the follower without it filters
            generated data, whose episodes would change.
    """

    name = "follower"
    sensors = ("depth", "segmentation")

    def __init__(self, *, streets: bool = False) -> None:
        super().__init__(
            Skills(
                perceive=perceive_as_given,
                read=parse_instruction,
                make_walk=make_street_navigator if streets else make_rule_navigator,
                find_cell=find_by_rules,
                notes=True,
            )
        )


def make_rule_navigator(body: AgentBody, meaning: Navigation, turn: int) -> PhasePlayer:  # noqa: ARG001 - both turns are alike
    """Return the player of a navigation phase by rules."""
    return Navigator(body, meaning)


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

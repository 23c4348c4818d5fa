"""The agent `vl_map`: a version with the visual encoder, and one with the sensor segmentation."""

from functools import partial

from arramon_agents.mapping.agent import MapAgent, PhasePlayer, Skills
from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.probabilistic_landmark_memory import ProbabilisticLandmarkMemory
from arramon_agents.mapping.probabilistic_room_memory import ProbabilisticRoomMemory
from arramon_agents.perception.eyes.encoder import Eyes, load_far
from arramon_agents.perception.eyes.perception import EyesPerception
from arramon_agents.perception.eyes.predicted_segmentation import LABELS
from arramon_agents.perception.percept import perceive_as_given
from arramon_agents.reading.reader.reader import LearnedReader
from arramon_agents.reading.reader.reader import load as load_reader
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.vl_map.navigator import MapNavigator
from arramon_agents.vl_map.placement_network import CellFinder
from arramon_agents.vl_map.policy import MapPolicy
from arramon_lang.meaning import Navigation

NAME = "vl_map"


class SeeingAgent(MapAgent):
    """Agent with learned perception, reading, navigation and placement, from RGB and depth alone.

    Args:
        policy: chooses waypoints.
        placement: finds the target cell of the room.
        eyes: visual encoder; None for the shipped one.
        reader: reader of instructions; None for the shipped one.
        looks: whether to look around while navigating.
        sums: whether to sum log probabilities over all views of a thing.
    """

    name = NAME
    sensors = ("rgb", "depth")
    uses_processes = True

    def __init__(
        self,
        policy: MapPolicy,
        placement: CellFinder,
        eyes: Eyes | None = None,
        reader: LearnedReader | None = None,
        *,
        looks: bool = True,
        sums: bool = True,
    ) -> None:
        reads = reader or load_reader()
        super().__init__(
            Skills(
                perceive=EyesPerception(eyes or load_far()),
                read=lambda _, text, phase: reads.read(text, phase),
                make_walk=partial(follow_policy, policy, looks=looks),
                find_cell=placement.find,
                labels=LABELS,
                make_landmarks=partial(ProbabilisticLandmarkMemory, sums=sums),
                make_room=ProbabilisticRoomMemory,
                keeps_landmarks=True,
                notes=True,
            )
        )


class SegmentationAgent(MapAgent):
    """`SeeingAgent` with the sensor segmentation in place of the visual encoder.

    Args:
        policy: chooses waypoints.
        placement: finds the target cell of the room.
        reader: reader of instructions.
        looks: whether to look around while navigating.
    """

    name = NAME
    sensors = ("depth", "segmentation")

    def __init__(self, policy: MapPolicy, placement: CellFinder, reader: LearnedReader, *, looks: bool = True) -> None:
        super().__init__(
            Skills(
                perceive=perceive_as_given,
                read=lambda _, text, phase: reader.read(text, phase),
                make_walk=partial(follow_policy, policy, looks=looks),
                find_cell=placement.find,
                keeps_landmarks=True,
                notes=True,
            )
        )


def follow_policy(
    policy: MapPolicy, body: AgentBody, meaning: Navigation, turn: int, *, looks: bool = True
) -> PhasePlayer:
    """Return the player of a navigation phase by a policy."""
    return MapNavigator(body, rows_of(meaning), policy.option_values, turn, looks=looks)

"""The agent `seeing_follower`: rule-based navigation and placement, with learned perception and reading."""

from pathlib import Path

from arramon_agents.follower.agent import make_estimating_navigator, make_rule_navigator
from arramon_agents.mapping.agent import MapAgent, Skills
from arramon_agents.mapping.probabilistic_landmark_memory import ProbabilisticLandmarkMemory
from arramon_agents.mapping.probabilistic_room_memory import ProbabilisticRoomMemory
from arramon_agents.mapping.room_player import find_by_rules
from arramon_agents.perception.eyes.encoder import Eyes, load_far
from arramon_agents.perception.eyes.perception import EyesPerception
from arramon_agents.perception.eyes.predicted_segmentation import LABELS
from arramon_agents.process_settings import prepare_process
from arramon_agents.reading.reader.reader import LearnedReader
from arramon_agents.reading.reader.reader import load as load_reader


class Agent(MapAgent):
    """Agent that follows instructions by hand-written rules, with learned perception and reading.

    Args:
        eyes: visual encoder; None for the shipped one.
        reader: reader of instructions, or its file; None for the shipped one.
        estimate_heading: whether to follow turn 2 from an estimate of the heading in which the reference ended turn 1.
    """

    name = "seeing_follower"
    sensors = ("rgb", "depth")
    uses_processes = True

    def __init__(
        self, eyes: Eyes | None = None, reader: LearnedReader | str | None = None, *, estimate_heading: bool = True
    ) -> None:
        prepare_process()
        perceive = EyesPerception(eyes or load_far())
        reads = reader if isinstance(reader, LearnedReader) else load_reader(Path(reader) if reader else None)
        super().__init__(
            Skills(
                perceive=perceive,
                read=lambda _, text, phase: reads.read(text, phase),
                make_walk=make_estimating_navigator if estimate_heading else make_rule_navigator,
                find_cell=find_by_rules,
                labels=LABELS,
                make_landmarks=ProbabilisticLandmarkMemory,
                make_room=ProbabilisticRoomMemory,
            )
        )

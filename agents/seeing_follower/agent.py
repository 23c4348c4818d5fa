"""The agent `seeing_follower`: rule-based navigation and placement, with learned perception and reading."""

from pathlib import Path

from arramon_agents.follower.agent import walk_by_rules
from arramon_agents.mapping.agent import MapAgent, Skills
from arramon_agents.mapping.landmark_beliefs import SeenLandmarks
from arramon_agents.mapping.room_beliefs import SeenRoom
from arramon_agents.mapping.room_player import find_by_rules
from arramon_agents.perception.eyes.encoder import Eyes
from arramon_agents.perception.eyes.encoder import load as load_eyes
from arramon_agents.perception.eyes.perception import EyesPerception
from arramon_agents.perception.eyes.sight import LABELS
from arramon_agents.reading.reader.reader import LearnedReader
from arramon_agents.reading.reader.reader import load as load_reader


class Agent(MapAgent):
    """Agent that follows instructions by hand-written rules, with learned perception and reading.

    Args:
        eyes: visual encoder; None for the shipped one.
        reader: reader of instructions, or its file; None for the shipped one.
    """

    name = "seeing_follower"
    sensors = ("rgb", "depth")

    def __init__(self, eyes: Eyes | None = None, reader: LearnedReader | str | None = None) -> None:
        perceive = EyesPerception(eyes or load_eyes())
        reads = reader if isinstance(reader, LearnedReader) else load_reader(Path(reader) if reader else None)
        super().__init__(
            Skills(
                perceive=perceive,
                read=lambda _, text, phase: reads.read(text, phase),
                make_walk=walk_by_rules,
                find_cell=find_by_rules,
                labels=LABELS,
                make_landmarks=SeenLandmarks,
                make_room=SeenRoom,
            )
        )

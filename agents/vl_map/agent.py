"""The agent `vl_map` in two versions: with the visual encoder, or with the sensor segmentation."""

from arramon_agents.follower.agent import Agent as Follower
from arramon_agents.follower.agent import Walk
from arramon_agents.mapping.body import Body
from arramon_agents.mapping.landmark_beliefs import SeenLandmarks
from arramon_agents.perception.eyes.encoder import Eyes
from arramon_agents.perception.eyes.sight import LABELS
from arramon_agents.reading.reader.reader import LearnedReader
from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.seeing_follower.agent import Agent as SeeingFollower
from arramon_agents.vl_map.navigator import MapNavigator
from arramon_agents.vl_map.policy import Policy
from arramon_agents.vl_map.room import Placement
from arramon_lang.meaning import Assembly, Navigation
from arramon_lang.room import Cell, Room

NAME = "vl_map"


class SeeingAgent(SeeingFollower):
    """Agent with learned perception, reading and navigation, from RGB and depth alone.

    Args:
        policy: chooses waypoints.
        placement: finds cells of the room.
        eyes: visual encoder; None for the shipped one.
        reader: of instructions; None for the shipped one.
        looks: whether it looks around in the streets.
        sums: whether what each view says of a thing is summed.
    """

    name = NAME

    def __init__(
        self,
        policy: Policy,
        placement: Placement,
        eyes: Eyes | None = None,
        reader: LearnedReader | None = None,
        *,
        looks: bool = True,
        sums: bool = True,
    ) -> None:
        super().__init__(eyes, reader)
        self._policy, self._placement, self._looks, self._sums = policy, placement, looks, sums

    def make_landmarks(self) -> SeenLandmarks:
        """Return an empty memory of landmarks."""
        return SeenLandmarks(LABELS, sums=self._sums)

    def forget(self, body: Body) -> None:
        """Discard the state that is not kept between turns."""
        body.landmarks.forget_collectibles()

    def make_walk(self, body: Body, meaning: Navigation, turn: int) -> Walk:
        """Return the player of a navigation phase."""
        return walk_by(self._policy, body, meaning, turn, looks=self._looks)

    def find_cell(self, meaning: Assembly, room: Room) -> Cell:
        """Return the cell for the object, given the instruction's meaning and the room's contents."""
        return self._placement.find(meaning, room)


class SegmentationAgent(Follower):
    """The same agent with the sensor segmentation in place of the visual encoder.

    Args:
        policy: chooses waypoints.
        placement: finds cells of the room.
        reader: of instructions.
        looks: whether it looks around in the streets.
    """

    name = NAME

    def __init__(self, policy: Policy, placement: Placement, reader: LearnedReader, *, looks: bool = True) -> None:
        super().__init__()
        self._policy, self._placement, self._reader, self._looks = policy, placement, reader, looks

    def forget(self, body: Body) -> None:
        """Discard the state that is not kept between turns."""
        body.landmarks.forget_collectibles()

    def make_walk(self, body: Body, meaning: Navigation, turn: int) -> Walk:
        """Return the player of a navigation phase."""
        return walk_by(self._policy, body, meaning, turn, looks=self._looks)

    def find_cell(self, meaning: Assembly, room: Room) -> Cell:
        """Return the cell for the object, given the instruction's meaning and the room's contents."""
        return self._placement.find(meaning, room)

    def read(self, language: str, text: str, phase: str) -> Navigation | Assembly:  # noqa: ARG002
        """Return the meaning of an instruction, as far as it is understood; the language is not used."""
        return self._reader.read(text, phase)


def walk_by(policy: Policy, body: Body, meaning: Navigation, turn: int, *, looks: bool = True) -> Walk:
    """Return the player of a navigation phase, by a policy."""
    return MapNavigator(body, rows_of(meaning), policy.choose, turn, looks=looks).act

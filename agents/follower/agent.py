"""The follower agent: reads each instruction, and passes it to the navigator or to the room follower."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import arramon_lang as lang
from arramon_agents.follower.navigation import Navigator
from arramon_agents.follower.room import RoomFollower, find_by_rules
from arramon_agents.mapping.body import Body
from arramon_client.agent import Action, Episode, Observation
from arramon_lang.meaning import Assembly, Navigation, Thing
from arramon_lang.room import Cell, Room

Walk = Callable[[int], Action]
"""Returns the next action of a navigation phase, given the steps left; called after the body has perceived."""


@dataclass
class _Memory:
    """Memory of an episode."""

    episode: Episode
    body: Body
    phase: tuple[int, str] = (0, "")
    walk: Walk | None = field(default=None)
    room: RoomFollower | None = field(default=None)


class Agent:
    """Agent that uses only the text, depth and segmentation: no pose, no given map, no ground truth."""

    name = "follower"
    sensors = ("depth", "segmentation")

    def __init__(self) -> None:
        self._episodes: dict[str, _Memory] = {}

    def begin(self, episode: Episode) -> None:
        """Start a new episode.

        Raises:
            ValueError: if the episode has no labels for its segmentation.
        """
        if not episode.labels:
            raise ValueError("follower requires the sensor segmentation, which this run does not have")
        self._episodes[episode.episode_id] = _Memory(episode, self.make_body(episode))

    def end(self, episode_id: str) -> None:
        """Discard the memory of an episode: its map alone takes 1.6 MB."""
        del self._episodes[episode_id]

    def act(self, observations: Sequence[Observation]) -> list[Action]:
        """Return one action for each observation."""
        return [self._act(observation, self._episodes[observation.episode_id]) for observation in observations]

    def make_body(self, episode: Episode) -> Body:
        """Return what perceives the streets of an episode."""
        return Body(episode.labels)

    def forget(self, body: Body) -> None:
        """Remove what is not kept from one turn to the next."""
        body.landmarks.forget()

    def make_walk(self, body: Body, meaning: Navigation, turn: int) -> Walk:  # noqa: ARG002
        """Return what plays a navigation phase of turn 1 or 2."""
        navigator = Navigator(body, meaning)
        return lambda _: navigator.act()

    def make_room(self, meaning: Assembly, episode: Episode) -> RoomFollower:
        """Return what plays an assembly phase."""
        return RoomFollower(meaning, episode.labels, self.find_cell)

    def find_cell(self, meaning: Assembly, room: Room) -> Cell:
        """Return the cell for the object by the meaning of an instruction and the contents of the room."""
        return find_by_rules(meaning, room)

    def read(self, language: str, text: str, phase: str) -> Navigation | Assembly:
        """Return the meaning of an instruction."""
        return read(language, text, phase)

    def _act(self, observation: Observation, memory: _Memory) -> Action:
        if (observation.turn, observation.phase) != memory.phase:
            memory.phase = observation.turn, observation.phase
            self._begin_phase(observation, memory)
        if memory.walk is not None:
            memory.body.perceive(observation)
            action = memory.walk(observation.steps_left)
            memory.body.record_action(action)
            return action
        assert memory.room is not None
        return Action(memory.room.act(observation))

    def _begin_phase(self, observation: Observation, memory: _Memory) -> None:
        memory.walk = memory.room = None
        memory.body.record_action(None)
        meaning = self.read(memory.episode.language, observation.instruction, observation.phase)
        if isinstance(meaning, Navigation):
            self.forget(memory.body)
            memory.walk = self.make_walk(memory.body, meaning, observation.turn)
        else:
            memory.room = self.make_room(meaning, memory.episode)


def read(language: str, text: str, phase: str) -> Navigation | Assembly:
    """Return the meaning of an instruction, or only the object that it mentions if it cannot be read."""
    speech = lang.load(language)
    try:
        return speech.read(text, phase)
    except lang.CannotRead:
        mentions = speech.find_objects(text)
        thing = Thing(mentions[0].kind or "", mentions[0].colour or "", mentions[0].pattern or "") if mentions else None
        if phase == "navigation":
            return Navigation((), thing or Thing(""))
        return Assembly((), thing or Thing(""), ())

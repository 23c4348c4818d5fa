"""The agent: reads each instruction, and gives it to what navigates or to what places."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import lang
from agents.follower.navigation import Navigator
from agents.follower.navigation_body import Body
from agents.follower.room import RoomFollower
from arramon_client.agent import Action, Episode, Observation
from lang.meaning import Assembly, Navigation, Thing


@dataclass
class _Memory:
    """What is remembered of an episode."""

    episode: Episode
    body: Body
    phase: tuple[int, str] = (0, "")
    navigator: Navigator | None = field(default=None)
    room: RoomFollower | None = field(default=None)


class Agent:
    """Plays from the text and what the camera shows: no position, no map, no ground truth."""

    name = "follower"
    sensors = ("depth", "segmentation")

    def __init__(self) -> None:
        self._episodes: dict[str, _Memory] = {}

    def begin(self, episode: Episode) -> None:
        """A new episode.

        Raises:
            ValueError: if the episode does not say what its segmentation means.
        """
        if not episode.labels:
            raise ValueError("follower needs the sensor segmentation, and this run does not have it")
        self._episodes[episode.episode_id] = _Memory(episode, Body(episode.labels))

    def act(self, observations: Sequence[Observation]) -> list[Action]:
        """One action for each observation."""
        return [self._act(observation, self._episodes[observation.episode_id]) for observation in observations]

    def _act(self, observation: Observation, memory: _Memory) -> Action:
        if (observation.turn, observation.phase) != memory.phase:
            memory.phase = observation.turn, observation.phase
            self._begin_phase(observation, memory)
        if memory.navigator is not None:
            memory.body.perceive(observation)
            action = memory.navigator.act()
            memory.body.did(action)
            return action
        assert memory.room is not None
        return Action(memory.room.act(observation))

    def _begin_phase(self, observation: Observation, memory: _Memory) -> None:
        memory.navigator = memory.room = None
        memory.body.did(None)
        meaning = read(memory.episode.language, observation.instruction, observation.phase)
        if isinstance(meaning, Navigation):
            memory.body.landmarks.forget()
            memory.navigator = Navigator(memory.body, meaning)
        else:
            memory.room = RoomFollower(meaning, memory.episode.labels)


def read(language: str, text: str, phase: str) -> Navigation | Assembly:
    """What an instruction means; where it cannot be read, only the object that it names."""
    speech = lang.load(language)
    try:
        return speech.read(text, phase)
    except lang.CannotRead:
        mentions = speech.find_objects(text)
        thing = Thing(mentions[0].kind or "", mentions[0].colour or "", mentions[0].pattern or "") if mentions else None
        if phase == "navigation":
            return Navigation((), thing or Thing(""))
        return Assembly((), thing or Thing(""), ())

"""Agent that keeps a map, composed of skills: perception, reading, navigation, and choice of the target cell."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.landmark_memory import LandmarkMemory
from arramon_agents.mapping.room_memory import RoomMemory
from arramon_agents.mapping.room_player import FindCell, RoomPlayer
from arramon_agents.perception.percept import Perceive, Percept
from arramon_client.agent import Action, Episode, Label, Observation
from arramon_lang.meaning import Assembly, Navigation

Read = Callable[[str, str, str], Navigation | Assembly]
"""Returns the meaning of an instruction, given language, text and phase."""

NextAction = Callable[[int], Action]
"""Returns the next action of a navigation phase, given the steps left; called after `AgentBody.perceive`."""

Labels = Sequence[Label]


@dataclass(frozen=True, kw_only=True)
class Skills:
    """Components of an agent that keeps a map.

    Attributes:
        perceive: perceives observations.
        read: parses instructions.
        make_walk: returns the player of a navigation phase, given the body, the meaning, and the turn (1 or 2).
        find_cell: chooses the target cell of the room.
        labels: labels of the perceived segmentation; None for the labels of the run's sensor.
        make_landmarks, make_room: return an empty memory of landmarks, and of the room, given the labels.
        keeps_landmarks: whether turn 2 keeps the landmarks of turn 1, except collectibles.
    """

    perceive: Perceive
    read: Read
    make_walk: Callable[[AgentBody, Navigation, int], NextAction]
    find_cell: FindCell
    labels: Labels | None = None
    make_landmarks: Callable[[Labels], LandmarkMemory] = LandmarkMemory
    make_room: Callable[[Labels], RoomMemory] = RoomMemory
    keeps_landmarks: bool = False


@dataclass
class _EpisodeState:
    """State of an episode: map, and the player of the current phase, `walk` or `room`."""

    language: str
    labels: Labels
    body: AgentBody
    phase: tuple[int, str] = (0, "")
    walk: NextAction | None = None
    room: RoomPlayer | None = None


class MapAgent:
    """Agent that keeps its own map, without pose or ground truth; it plays many episodes at a time.

    Args:
        skills: components of the agent.
    """

    def __init__(self, skills: Skills) -> None:
        self._skills = skills
        self._episodes: dict[str, _EpisodeState] = {}

    def begin(self, episode: Episode) -> None:
        """Start a new episode.

        Raises:
            ValueError: if the agent needs the labels of the segmentation, and the episode has none.
        """
        labels = self._skills.labels or episode.labels
        if not labels:
            raise ValueError("follower requires the sensor segmentation, which this run does not have")
        body = AgentBody(labels, self._skills.make_landmarks(labels))
        self._episodes[episode.episode_id] = _EpisodeState(episode.language, labels, body)

    def end(self, episode_id: str) -> None:
        """Discard the state of an episode: its map takes 1.6 MB."""
        del self._episodes[episode_id]

    def act(self, observations: Sequence[Observation]) -> list[Action]:
        """Return one action for each observation."""
        percepts = self._skills.perceive(observations)
        return [self._act(percept, self._episodes[percept.observation.episode_id]) for percept in percepts]

    def _act(self, percept: Percept, memory: _EpisodeState) -> Action:
        observation = percept.observation
        if (observation.turn, observation.phase) != memory.phase:
            memory.phase = observation.turn, observation.phase
            self._begin_phase(observation, memory)
        if memory.walk is not None:
            memory.body.perceive(observation, percept.things)
            action = memory.walk(observation.steps_left)
            memory.body.record_action(action)
            return action
        assert memory.room is not None
        return Action(memory.room.act(observation, percept.things))

    def _begin_phase(self, observation: Observation, memory: _EpisodeState) -> None:
        skills = self._skills
        memory.walk = memory.room = None
        memory.body.record_action(None)
        meaning = skills.read(memory.language, observation.instruction, observation.phase)
        if isinstance(meaning, Navigation):
            if skills.keeps_landmarks:
                memory.body.landmarks.forget_collectibles()
            else:
                memory.body.landmarks.forget()
            memory.walk = skills.make_walk(memory.body, meaning, observation.turn)
        else:
            memory.room = RoomPlayer(meaning, skills.make_room(memory.labels), skills.find_cell)

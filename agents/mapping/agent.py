"""An agent that keeps a map, made of skills: how it perceives, reads, walks, and finds the room's cell."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.landmarks import Landmarks
from arramon_agents.mapping.room import RoomSight
from arramon_agents.mapping.room_player import FindCell, RoomFollower
from arramon_agents.perception.percept import Perceive, Percept
from arramon_client.agent import Action, Episode, Label, Observation
from arramon_lang.meaning import Assembly, Navigation

Read = Callable[[str, str, str], Navigation | Assembly]
"""Returns the meaning of an instruction by language, text and phase."""

NextAction = Callable[[int], Action]
"""Returns the next action of a navigation phase, given the steps left; called after the body has perceived."""

Labels = Sequence[Label]


@dataclass(frozen=True, kw_only=True)
class Skills:
    """What an agent that keeps a map is made of.

    Attributes:
        perceive: observations.
        read: instructions.
        make_walk: returns what plays a navigation phase of turn 1 or 2, given the body and the meaning.
        find_cell: returns the room's cell for the object.
        labels: of the pixels that it perceives; None for those of the run's segmentation.
        make_landmarks, make_room: return an empty memory of the streets, and of the room, given the labels.
        keeps_landmarks: whether turn 2 knows the landmarks of turn 1, without its collectibles.
    """

    perceive: Perceive
    read: Read
    make_walk: Callable[[AgentBody, Navigation, int], NextAction]
    find_cell: FindCell
    labels: Labels | None = None
    make_landmarks: Callable[[Labels], Landmarks] = Landmarks
    make_room: Callable[[Labels], RoomSight] = RoomSight
    keeps_landmarks: bool = False


@dataclass
class _EpisodeState:
    """Memory of an episode: the player of its current phase is either a walk or a room follower."""

    language: str
    labels: Labels
    body: AgentBody
    phase: tuple[int, str] = (0, "")
    walk: NextAction | None = None
    room: RoomFollower | None = None


class MapAgent:
    """Agent that uses neither pose nor a given map nor ground truth; it plays many episodes at a time.

    Args:
        skills: what it is made of.
    """

    def __init__(self, skills: Skills) -> None:
        self._skills = skills
        self._episodes: dict[str, _EpisodeState] = {}

    def begin(self, episode: Episode) -> None:
        """Start a new episode.

        Raises:
            ValueError: if the episode has no labels for its segmentation, which is needed.
        """
        labels = self._skills.labels or episode.labels
        if not labels:
            raise ValueError("follower requires the sensor segmentation, which this run does not have")
        body = AgentBody(labels, self._skills.make_landmarks(labels))
        self._episodes[episode.episode_id] = _EpisodeState(episode.language, labels, body)

    def end(self, episode_id: str) -> None:
        """Discard the memory of an episode: its map alone takes 1.6 MB."""
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
            memory.room = RoomFollower(meaning, skills.make_room(memory.labels), skills.find_cell)

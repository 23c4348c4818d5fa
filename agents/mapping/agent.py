"""Agent that keeps a map, composed of skills: perception, reading, navigation, and choice of the target cell."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.landmark_memory import LandmarkMemory
from arramon_agents.mapping.notes import HasIntent, Intent, reading
from arramon_agents.mapping.room_memory import RoomMemory
from arramon_agents.mapping.room_player import FindCell, RoomPlayer
from arramon_agents.perception.percept import Perceive, Percept
from arramon_client.agent import Action, Answer, Episode, Label, Observation
from arramon_lang.meaning import Assembly, Navigation

Read = Callable[[str, str, str], Navigation | Assembly]
"""Returns the meaning of an instruction, given language, text and phase."""


class PhasePlayer(HasIntent, Protocol):
    """Player of one navigation phase."""

    def act(self, steps_left: int) -> Action:
        """Return the next action, given the steps left; called after `AgentBody.perceive`."""
        ...


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
        notes: whether the agent leaves notes: what it read, and what it is about to do, whenever that has changed.
    """

    perceive: Perceive
    read: Read
    make_walk: Callable[[AgentBody, Navigation, int], PhasePlayer]
    find_cell: FindCell
    labels: Labels | None = None
    make_landmarks: Callable[[Labels], LandmarkMemory] = LandmarkMemory
    make_room: Callable[[Labels], RoomMemory] = RoomMemory
    keeps_landmarks: bool = False
    notes: bool = False


@dataclass
class _MapEpisode:
    """An episode of the map agent: its map, and the player of the current phase, `walk` or `room`."""

    language: str
    labels: Labels
    body: AgentBody
    phase: tuple[int, str] = (0, "")
    walk: PhasePlayer | None = None
    room: RoomPlayer | None = None
    read: Navigation | Assembly | None = None
    noted: Intent | None = None


class MapAgent:
    """Agent that keeps its own map, without pose or ground truth; it plays many episodes at a time.

    Args:
        skills: components of the agent.
    """

    def __init__(self, skills: Skills) -> None:
        self._skills = skills
        self._episodes: dict[str, _MapEpisode] = {}

    def begin(self, episode: Episode) -> None:
        """Start a new episode.

        Raises:
            ValueError: if the agent needs the labels of the segmentation, and the episode has none.
        """
        labels = self._skills.labels or episode.labels
        if not labels:
            raise ValueError("follower requires the sensor segmentation, which this run does not have")
        body = AgentBody(labels, self._skills.make_landmarks(labels))
        self._episodes[episode.episode_id] = _MapEpisode(episode.language, labels, body)

    def end(self, episode_id: str) -> None:
        """Discard the state of an episode: its map takes 1.6 MB."""
        del self._episodes[episode_id]

    def act(self, observations: Sequence[Observation]) -> list[int | Answer]:
        """Return one action for each observation, with a note if there is something new to note."""
        percepts = self._skills.perceive(observations)
        return [self._answer(percept, self._episodes[percept.observation.episode_id]) for percept in percepts]

    def _answer(self, percept: Percept, memory: _MapEpisode) -> int | Answer:
        action = self._act(percept, memory)
        note = self._note(memory) if self._skills.notes else {}
        return Answer(action, note) if note else action

    def _act(self, percept: Percept, memory: _MapEpisode) -> Action:
        observation = percept.observation
        if (observation.turn, observation.phase) != memory.phase:
            memory.phase = observation.turn, observation.phase
            self._begin_phase(observation, memory)
        if memory.walk is not None:
            memory.body.perceive(observation, percept.things)
            action = memory.walk.act(observation.steps_left)
            memory.body.record_action(action)
            return action
        assert memory.room is not None
        return Action(memory.room.act(observation, percept.things))

    def _begin_phase(self, observation: Observation, memory: _MapEpisode) -> None:
        skills = self._skills
        memory.walk = memory.room = memory.noted = None
        memory.body.record_action(None)
        meaning = memory.read = skills.read(memory.language, observation.instruction, observation.phase)
        if isinstance(meaning, Navigation):
            if skills.keeps_landmarks:
                memory.body.landmarks.forget_collectibles()
            else:
                memory.body.landmarks.forget()
            memory.walk = skills.make_walk(memory.body, meaning, observation.turn)
        else:
            memory.room = RoomPlayer(meaning, skills.make_room(memory.labels), skills.find_cell)

    @staticmethod
    def _note(memory: _MapEpisode) -> dict[str, Any]:
        """Return what has changed since the last note: what was read, and the intent; empty if nothing has."""
        player = memory.walk or memory.room
        assert player is not None
        assert memory.read is not None
        intent = player.intent()
        read = reading(memory.read) if memory.noted is None else {}
        note = {**read, **intent} if intent != memory.noted else {}
        memory.noted = intent
        return note

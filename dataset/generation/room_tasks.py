"""Random assembly tasks without a city, with instructions in several languages from one plan."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from random import Random

import arramon_lang as lang
from arramon_client.world import Action
from arramon_dataset.generation.assembly_tasks import draw_decoys, draw_tasks
from arramon_dataset.generation.batches import GeneratedEpisode
from arramon_dataset.instructions.assembly.plan import plan_assembly
from arramon_dataset.instructions.assembly.visible_objects import whole_room
from arramon_dataset.instructions.gate.assembly import faults_of_assembly
from arramon_dataset.instructions.gate.texts import faults_of_text
from arramon_dataset.randomness import seeded
from arramon_lang.meaning import Assembly, Navigation, Rotate, Thing
from arramon_server.episodes.episode import Episode, Instructions, Turn
from arramon_server.episodes.splits import ROOMS_SPLIT
from arramon_server.errors import ArraMonError
from arramon_server.sim.catalogue import ALL_TYPES, ObjectType
from arramon_server.sim.geometry import Point, Pose
from arramon_server.sim.rules import Collectible, PlacedObject
from arramon_server.sim.section import Section

PREFIX = "room-"
"""Prefix of a task's id, before its number."""

ATTEMPTS = 200
"""Maximum number of drafts of one task."""

BATCH_SIZE = 50
"""Tasks in one batch."""

ROOM_SECTION = Section(ROOMS_SPLIT, 0.0, (-5.0, -5.0, 5.0, 5.0), (), ())
"""The empty ground on which the agent picks each object up."""

BEFORE_AGENT = Point(0.0, 0.1, 1.5)
"""Where each object lies: within reach of the start pose."""


@dataclass(frozen=True, slots=True)
class RoomBatch:
    """Room tasks to generate (`batches.GenerationBatch`).

    Attributes:
        seed: of all random choices.
        episode_ids: of the tasks.
    """

    seed: int
    episode_ids: tuple[str, ...]

    def generate(self) -> list[GeneratedEpisode]:
        """Generate the tasks, in all required languages.

        Raises:
            ArraMonError: if a task cannot be drawn.
        """
        return [self._make(episode_id) for episode_id in self.episode_ids]

    def _make(self, episode_id: str) -> GeneratedEpisode:
        made = draw_task(episode_id, (ROOMS_SPLIT, self.seed, episode_id), lang.required(), _is_true)
        if made is None:
            raise ArraMonError(f"no valid room task {episode_id} found in {ATTEMPTS} attempts")
        return made


def room_ids(count: int) -> list[str]:
    """Return the ids of the first tasks."""
    return [f"{PREFIX}{number}" for number in range(count)]


def room_batches(seed: int, episode_ids: Sequence[str]) -> list[RoomBatch]:
    """Return batches for the tasks with these ids."""
    return [
        RoomBatch(seed, tuple(episode_ids[first : first + BATCH_SIZE]))
        for first in range(0, len(episode_ids), BATCH_SIZE)
    ]


Meanings = tuple[Assembly, Assembly]


def draw_task(
    episode_id: str,
    names: tuple[object, ...],
    languages: Sequence[str],
    accepts: Callable[[Episode, Meanings], bool],
) -> GeneratedEpisode | None:
    """Return a random task, or None if no draft is accepted.

    Drafts that one of the languages cannot express are rejected. Otherwise the task does not depend on the languages.

    Args:
        episode_id: of the task.
        names: seed of all random choices.
        languages: codes of the languages of the instructions.
        accepts: returns whether a draft is accepted, given its episode and the meanings of both assembly instructions.
    """
    for attempt in range(ATTEMPTS):
        drawn = _draft(episode_id, languages, (*names, attempt))
        if drawn is not None and accepts(*drawn):
            return GeneratedEpisode(drawn[0], attempt + 1)
    return None


def _is_true(episode: Episode, meanings: Meanings) -> bool:
    """Return whether all texts are true of the room, by the same gate as all generated instructions."""
    room = episode.decoys
    for number, (turn, meaning) in enumerate(zip(episode.turns, meanings, strict=True), start=1):
        cell = turn.target_cell.column, turn.target_cell.row
        if faults_of_assembly(meaning, cell, whole_room(room)):
            return False
        if any(
            faults_of_text(episode.instruction(code, number, "assembly"), code, meaning)
            for code in episode.instructions
        ):
            return False
        room = (*room, PlacedObject(turn.target.type, turn.target_cell))
    return True


def _draft(episode_id: str, languages: Sequence[str], names: tuple[object, ...]) -> tuple[Episode, Meanings] | None:
    """Return a task and its meanings, or None if its decoys or its instructions cannot be made."""
    random = seeded(*names, "task")
    first, second = random.sample(ALL_TYPES, 2)
    tasks = draw_tasks(random)
    decoys = draw_decoys(f"{names}", (first, second), tasks)
    if decoys is None:
        return None
    turns, meanings, room = [], [], decoys
    for number, (target, task) in enumerate(zip((first, second), tasks, strict=True), start=1):
        try:
            meaning = plan_assembly(target, task.cell, room, seeded(*names, number, "plan"))
        except ValueError:  # The target's level does not fit the objects in the room.
            return None
        if meaning is None:
            return None
        meanings.append(meaning)
        turns.append(
            Turn(
                path=((0.0, 0.0),),
                actions=(Action.INTERACT,),
                room_path=task.path,
                room_actions=task.actions,
                street=(Collectible(target, BEFORE_AGENT),),
                target_cell=task.cell,
            )
        )
        room = (*room, PlacedObject(target, task.cell))
    texts = _texts(languages, (first, second), meanings, names)
    if texts is None:
        return None
    episode = Episode(episode_id, ROOM_SECTION.id, Pose(0.0, 0.0, 0.0), (turns[0], turns[1]), decoys, texts)
    return episode, (meanings[0], meanings[1])


def _texts(
    languages: Sequence[str],
    targets: tuple[ObjectType, ObjectType],
    meanings: Sequence[Assembly],
    names: tuple[object, ...],
) -> Mapping[str, tuple[Instructions, Instructions]] | None:
    """Return the instructions of both turns by language, or None if a language cannot express a meaning."""
    texts = {}
    for code in languages:
        turns = [
            _write(code, target, meaning, seeded(*names, number, code))
            for number, (target, meaning) in enumerate(zip(targets, meanings, strict=True), start=1)
        ]
        if turns[0] is None or turns[1] is None:
            return None
        texts[code] = (turns[0], turns[1])
    return texts


def _write(language: str, target: ObjectType, meaning: Assembly, random: Random) -> Instructions | None:
    """Return the instructions of a turn, or None if the language cannot express the meaning."""
    speech = lang.load(language)
    thing = Thing(target.kind, target.colour, target.pattern)
    try:
        return Instructions(speech.write(Navigation((Rotate("right"),), thing), random), speech.write(meaning, random))
    except ValueError:
        return None

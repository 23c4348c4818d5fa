"""Tasks in the room alone, drawn from a seed: no city, no data folder, instructions in every language."""

from functools import cache, lru_cache
from pathlib import Path
from random import Random

import lang
from arramon_client.environments.backend import Settings, SplitInfo
from arramon_client.environments.backend import Texts as ClientTexts
from arramon_client.errors import UsageError
from lang.meaning import Assembly, Navigation, Rotate, Thing
from server.dataset.generation.rooms import draw_decoys, draw_tasks
from server.dataset.instructions.assembly import plan_assembly
from server.dataset.randomness import seeded
from server.environments.library import Library
from server.episodes.episode import Episode, Instructions, Turn
from server.episodes.splits import SENSORS, Split
from server.episodes.texts import instructions_in
from server.runs.play.worlds import Worlds
from server.sim.catalogue import ALL_TYPES, ObjectType
from server.sim.geometry import Point, Pose
from server.sim.rules import STEPS_PER_PHASE, Action, Collectible, PlacedObject
from server.sim.section import Section

ROOMS = "rooms"
"""Name of the split that holds the drawn tasks."""

PREFIX = "room-"
"""Before the seed, in an episode's id."""

ATTEMPTS = 200
"""Drafts of one task before drawing fails."""

SURVEYED = 24
"""Tasks whose instructions give the length that no instruction may exceed."""

SECTION = Section(ROOMS, 0.0, (-5.0, -5.0, 5.0, 5.0), (), ())
"""The empty ground on which the agent picks each object up."""

BEFORE_AGENT = Point(0.0, 0.1, 1.5)
"""Where each object lies: within reach of the start pose."""


@lru_cache(2)
def room_library(camera: str) -> Library:
    """Return the split and the worlds of drawn tasks. The split's episodes are not listed: there is no end of them."""
    split = Split(ROOMS, hidden=False, source="drawn", episodes={}, sections={SECTION.id: SECTION}, data_hash="")
    return Library(split, Worlds({ROOMS: split}, camera))


def room_split(settings: Settings) -> SplitInfo:
    """Return what environments have to know of the drawn tasks.

    Raises:
        UsageError: if there is no such language.
    """
    if settings.language not in lang.available():
        there = ", ".join(lang.available())
        raise UsageError(f"there is no language {settings.language!r}; there are {there}")
    return SplitInfo(
        name=ROOMS,
        hidden=False,
        sensors=tuple(name for name in SENSORS if name != "oracle"),
        steps_per_phase=settings.steps_per_phase or STEPS_PER_PHASE,
        data_hash="",
        texts={settings.language: _texts(settings.language)},
    )


def draw_room(seed: int, language: str, episode_id: str | None = None) -> Episode:
    """Return the task of a seed, with instructions in one language.

    The task is the same in every language that can express it.

    Args:
        seed: of all choices.
        language: of the instructions.
        episode_id: "room-" and a seed, which then counts instead of `seed`.

    Raises:
        UsageError: if the id is not of that form.
    """
    if episode_id is not None:
        number = episode_id.removeprefix(PREFIX)
        if not (episode_id.startswith(PREFIX) and number.isdecimal()):
            raise UsageError(
                f"there is no episode {episode_id!r}: the ids of drawn tasks are {PREFIX}0, {PREFIX}1, ..."
            )
        seed = int(number)
    texts = _texts(language)
    episode = _draw(seed, language, texts.longest, texts.longest_utf8)
    if episode is None:
        raise UsageError(f"no task could be drawn from the seed {seed}; use another")
    return episode


def _draw(seed: int, language: str, longest: int, longest_utf8: int) -> Episode | None:
    for attempt in range(ATTEMPTS):
        names = (ROOMS, seed, attempt)
        episode = _draft(f"{PREFIX}{seed}", language, names)
        if episode is None:
            continue
        texts = instructions_in([episode], language)
        if all(len(text) <= longest and len(text.encode()) <= longest_utf8 for text in texts):
            return episode
    return None


def _draft(episode_id: str, language: str, names: tuple[object, ...]) -> Episode | None:
    """Return a task, or None if its decoys or its instructions do not come out."""
    random = seeded(*names, "task")
    first, second = random.sample(ALL_TYPES, 2)
    tasks = draw_tasks(random)
    decoys = draw_decoys(f"{names}", (first, second), tasks)
    if decoys is None:
        return None
    turns, texts, room = [], [], decoys
    for number, (target, task) in enumerate(zip((first, second), tasks, strict=True), start=1):
        try:
            meaning = plan_assembly(target, task.cell, room, seeded(*names, number, "plan"))
        except ValueError:  # A draft that puts the target on another level than the room's objects allow.
            return None
        if meaning is None:
            return None
        instructions = _write(language, target, meaning, seeded(*names, number, language))
        if instructions is None:
            return None
        texts.append(instructions)
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
    start = Pose(0.0, 0.0, 0.0)
    return Episode(episode_id, SECTION.id, start, (turns[0], turns[1]), decoys, {language: (texts[0], texts[1])})


def _write(language: str, target: ObjectType, meaning: Assembly, random: Random) -> Instructions | None:
    """Return the instructions of a turn, or None if the language cannot express the meaning."""
    speech = lang.load(language)
    thing = Thing(target.kind, target.colour, target.pattern)
    try:
        return Instructions(speech.write(Navigation((Rotate("right"),), thing), random), speech.write(meaning, random))
    except ValueError:
        return None


@cache
def _texts(language: str) -> ClientTexts:
    """Return the alphabet and the lengths of a language's drawn tasks: twice the longest of those surveyed."""
    folder = Path(next(iter(lang.__path__))) / language
    written = "".join(path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.toml")))
    drawn = [_draw(seed, language, 1_000_000, 1_000_000) for seed in range(SURVEYED)]
    texts = instructions_in([episode for episode in drawn if episode is not None], language)
    alphabet = {character for character in written + "".join(texts) if character.isprintable()}
    return ClientTexts(
        alphabet="".join(sorted(alphabet | {character.upper()[0] for character in alphabet})),
        longest=2 * max(map(len, texts)),
        longest_utf8=2 * max(len(text.encode()) for text in texts),
    )

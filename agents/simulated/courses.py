"""Courses for simulated walks, one per turn of an episode: section, reference path, parsed instructions."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import arramon_lang as lang
from arramon_agents.reading.reader.reader import LearnedReader
from arramon_agents.reading.reader.slots import Row, rows_of
from arramon_agents.simulated.training_split import read_training_split
from arramon_agents.simulated.world import StreetWorld, Things
from arramon_client.world import NAVIGATION, Action
from arramon_lang.meaning import Meaning, Navigation
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split, split_folders
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.rules import Collectible

EXTRA_SPLIT = "train_extra"
"""Additional training split, in generated sections; used if the data folder has it."""


@dataclass(frozen=True, eq=False)
class Course:
    """The navigation phase of one turn.

    Attributes:
        world, things: streets of the section, and the things in them.
        start: initial pose in the world (x, z, heading in radians).
        path: reference path, (n, 2) of (x, z).
        items: collectibles; the first is the target.
        turn: 1 or 2.
        readings: the instruction as rows, alternatives: the true meaning, unless the grammar cannot parse the text, and
            the reader's output for each language.
        arcs: (n,) distance along the path from its start to each point, in units.
    """

    world: StreetWorld
    things: Things
    start: tuple[float, float, float]
    path: npt.NDArray[np.float64]
    items: Sequence[Collectible]
    turn: int
    readings: Sequence[Sequence[Row]]
    arcs: npt.NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        steps = np.hypot(*np.diff(self.path, axis=0).T) if len(self.path) > 1 else np.zeros(0)
        object.__setattr__(self, "arcs", np.concatenate([[0.0], np.cumsum(steps)]))

    @property
    def target(self) -> tuple[float, float]:
        """The target's place (x, z)."""
        at = self.items[0].position
        return at.x, at.z


def courses_of(
    split: Split, episodes: Sequence[Episode], languages: Sequence[str], reader: LearnedReader, *, meant: bool = True
) -> Iterator[Course]:
    """Yield the turns of episodes.

    Args:
        split: split of the episodes.
        episodes: the episodes.
        languages: languages of the instructions.
        reader: reader of instructions.
        meant: whether the first reading is the true meaning, parsed by the grammar of the first language. A text that
            the grammar cannot parse, such as a person's, has the reader's output alone.

    Raises:
        ValueError: if a turn has no reading; names it.
    """
    worlds: dict[str, StreetWorld] = {}
    for episode in episodes:
        section = furnished(split.sections[episode.section], episode.furniture)
        if episode.furniture.is_empty:
            if episode.section not in worlds:
                worlds[episode.section] = StreetWorld(section)
            world = worlds[episode.section]
        else:
            world = StreetWorld(section)
        heading = episode.start.heading
        for number, turn in enumerate(episode.turns, start=1):
            texts = {language: episode.instruction(language, number, "navigation") for language in languages}
            meanings = [reader.read(text, "navigation") for text in texts.values()]
            if meant:
                meanings = [*true_meaning(texts[languages[0]], languages[0], NAVIGATION), *meanings]
            readings = [rows for rows in map(_rows, meanings) if rows]
            if not readings:
                raise ValueError(f"episode {episode.episode_id!r}, turn {number}: no step is read in its instruction")
            things = Things(world.props, list(turn.street))
            start = *turn.path[0], math.radians(heading)
            yield Course(world, things, start, np.array(turn.path), turn.street, number, readings)
            turned = sum({Action.LEFT: -30.0, Action.RIGHT: 30.0}.get(action, 0.0) for action in turn.actions)
            heading += turned


def true_meaning(text: str, language: str, phase: str) -> list[Meaning]:
    """Return the meaning that the grammar of a language parses in a text; none if it cannot parse the text."""
    try:
        return [lang.load(language).read(text, phase)]
    except lang.CannotRead:
        return []


def _rows(meaning: object) -> list[Row]:
    """Convert a meaning to rows; empty if they cannot express it."""
    assert isinstance(meaning, Navigation)
    try:
        return rows_of(meaning)
    except ValueError:
        return []


def training_splits(data: Path) -> list[str]:
    """Return the names of the training splits: `train`, and `train_extra` if the data folder has it."""
    return ["train", *(folder.name for folder in split_folders(data) if folder.name == EXTRA_SPLIT)]


def training_episodes(data: Path, languages: Sequence[str], episodes: int) -> list[tuple[Split, list[Episode]]]:
    """Return the training splits, `train` and `train_extra`, each with the episodes that have all languages.

    Args:
        data: data folder.
        languages: languages of the instructions.
        episodes: number of episodes of each split, the first in playing order; 0 for all.

    Raises:
        UsageError: if a split is missing or invalid.
        ValueError: if it lacks a language.
    """
    splits = [read_training_split(data, name) for name in training_splits(data)]
    found = []
    for split in splits:
        for language in languages:
            if language not in split.languages:
                raise ValueError(
                    f"the split {split.name!r} has no language {language!r}; it has {', '.join(split.languages)}"
                )
        chosen = [
            episode
            for episode in split.in_playing_order(*languages)
            if all(language in episode.instructions for language in languages)
        ]
        found.append((split, chosen[: episodes or None]))
    return found


class TrainingCourses(NamedTuple):
    """Courses of the training splits.

    Attributes:
        pairs: courses of the two turns of each episode.
        names: split and id of each episode.
        data_hash: hash of the split `train`.
    """

    pairs: Sequence[tuple[Course, Course]]
    names: Sequence[tuple[str, str]]
    data_hash: str


def training_courses(data: Path, languages: Sequence[str], episodes: int, reader: LearnedReader) -> TrainingCourses:
    """Return the courses for training; arguments as for `training_episodes`, and the reader.

    Raises:
        UsageError: if a split is missing or invalid.
        ValueError: if it lacks a language.
    """
    found = training_episodes(data, languages, episodes)
    courses = [course for split, chosen in found for course in courses_of(split, chosen, languages, reader)]
    pairs = list(zip(courses[::2], courses[1::2], strict=True))
    names = [(split.name, episode.episode_id) for split, chosen in found for episode in chosen]
    return TrainingCourses(pairs, names, found[0][0].data_hash)

"""From files of the official release to splits in the data folder: merged, furnished, and with a city around them."""

import logging
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import reduce
from pathlib import Path

import numpy as np

import lang
from lang.meaning import Assembly
from server.episodes.episode import Episode, with_languages
from server.episodes.extras import Points, Reference, decoys, distracters, read_references
from server.episodes.reconstruct import reconstruct
from server.episodes.release import read_release
from server.episodes.splits import Split, folder_of, read_split, write_split
from server.errors import BadFile, BadInput
from server.sim.room import Placement
from server.sim.rules import Collectible, PlacedObject, moved
from server.sim.section import Section

SOURCE = "imported from the official release's format"

_log = logging.getLogger(__name__)


def import_release(
    files: Sequence[Path], data: Path, *, split: str | None = None, language: str | None = None, hidden: bool = False
) -> list[Split]:
    """Brings release files into the data folder.

    A file of another language than one that is there already, or that is given beside it, adds its language to the
    episodes of the same `mapId`. Nothing is written unless all files are right.

    Args:
        files: in the release's format, of any language.
        data: the data folder.
        split: its name; None to take it from each file's name (`val_seen.json`, `val_seen_hindi.json`).
        language: of all the files; None to tell it from each one's texts.
        hidden: whether targets, goals and paths must never leave the server.

    Returns:
        The splits that were written.

    Raises:
        BadFile: if a file is wrong, or contradicts another of the same split.
        BadInput: for an unknown language.
        StorageError: if the data folder cannot be written.
    """
    if language is not None and language not in lang.available():
        raise BadInput(f"there is no language {language!r}; there are {', '.join(lang.available())}")
    gathered: dict[str, dict[str, Episode]] = {}
    for file in files:
        name = split or split_name(file)
        if name not in gathered:
            gathered[name] = _present(data, name)
        spoken, episodes = read_release(file, language)
        _merge(gathered[name], episodes, spoken, file)
    return [_write(data, name, episodes.values(), hidden) for name, episodes in gathered.items()]


def split_name(file: Path) -> str:
    """The split of a release file: its name without the language's."""
    name = file.stem
    for code in lang.available():
        name = name.removesuffix(f"_{lang.load(code).english_name.lower()}").removesuffix(f"_{code}")
    return name


def _present(data: Path, name: str) -> dict[str, Episode]:
    """What a split holds already, as bare as the release has it."""
    folder = folder_of(data, name)
    if not folder.exists():
        return {}
    split = read_split(folder)
    if split.source != SOURCE:
        raise BadInput(f"split {name!r} is there and was not imported; choose another name with --split")
    return {episode_id: _bare(episode) for episode_id, episode in split.episodes.items()}


def _bare(episode: Episode) -> Episode:
    first, second = (replace(turn, street=turn.street[:1]) for turn in episode.turns)
    return replace(episode, turns=(first, second), decoys=())


def _merge(episodes: dict[str, Episode], more: Iterable[Episode], language: str, file: Path) -> None:
    for episode in more:
        known = episodes.get(episode.episode_id)
        if known is None:
            episodes[episode.episode_id] = episode
            continue
        if (known.turns, known.start) != (episode.turns, episode.start):
            raise BadFile(file, f"mapId {episode.episode_id} has other paths or targets than in the files before")
        if known.instructions.get(language, episode.instructions[language]) != episode.instructions[language]:
            raise BadFile(
                file, f"mapId {episode.episode_id} has other {language!r} instructions than there are already"
            )
        episodes[episode.episode_id] = with_languages(known, episode.instructions)


def _write(data: Path, name: str, episodes: Iterable[Episode], hidden: bool) -> Split:
    by_section: dict[str, list[Episode]] = {}
    for episode in sorted(episodes, key=lambda episode: int(episode.episode_id)):
        by_section.setdefault(episode.section, []).append(episode)
    grounds = {section: _ground(members) for section, members in by_section.items()}
    furnished = [furnish(episode, grounds[episode.section]) for members in by_section.values() for episode in members]
    sections = [_section(section, members) for section, members in by_section.items()]
    _log.info("split %s: %d episodes in %d sections", name, len(furnished), len(sections))
    return write_split(data, name, hidden=hidden, source=SOURCE, episodes=furnished, sections=sections)


def _section(section: str, episodes: Sequence[Episode]) -> Section:
    turns = [turn for episode in episodes for turn in episode.turns]
    targets = np.array([(turn.target.position.x, turn.target.position.z) for turn in turns])
    return reconstruct(section, [np.array(turn.path) for turn in turns], targets)


def _ground(episodes: Sequence[Episode]) -> Points:
    """(m, 2): where agents of a section walk."""
    ground: Points = np.unique(np.concatenate([np.array(t.path) for e in episodes for t in e.turns]).round(2), axis=0)
    return ground


def furnish(episode: Episode, ground: Points) -> Episode:
    """The episode with its distracters and decoys, drawn from its id.

    Args:
        episode: as the release has it.
        ground: (m, 2) of (x, z) where agents of its section walk.
    """
    pose, turns = episode.start, []
    for number, turn in enumerate(episode.turns, start=1):
        pose = reduce(moved, turn.actions, pose)
        others = distracters(
            episode.episode_id, number, turn.target.type, turn.target.position, np.array(turn.path), pose, ground
        )
        turns.append(replace(turn, street=(turn.target, *(Collectible(*other) for other in others))))
    first, second = turns
    room = decoys(
        episode.episode_id,
        (first.target.type, second.target.type),
        (first.target_cell, second.target_cell),
        (first.room_path, second.room_path),
        _references(episode),
        _meanings(episode),
    )
    placed = tuple(PlacedObject(kind, Placement(cell.column, 1, cell.row)) for kind, cell in room)
    return replace(episode, turns=(first, second), decoys=placed)


def _references(episode: Episode) -> tuple[tuple[Reference, ...], tuple[Reference, ...]]:
    """What the assembly instructions mention, read in the first language by code: in English where there is that."""
    code = min(episode.instructions)
    first, second = (read_references(text.assembly, lang.load(code)) for text in episode.instructions[code])
    return first, second


def _meanings(episode: Episode) -> tuple[Assembly | None, Assembly | None]:
    """What the assembly instructions mean, in the same language; None for one that cannot be read."""
    code = min(episode.instructions)
    first, second = (_meaning(text.assembly, lang.load(code)) for text in episode.instructions[code])
    return first, second


def _meaning(text: str, language: lang.Language) -> Assembly | None:
    try:
        meaning = language.read(text, "assembly")
    except lang.CannotRead:
        return None
    assert isinstance(meaning, Assembly)  # of this phase it is nothing else
    return meaning

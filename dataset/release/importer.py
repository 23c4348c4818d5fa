"""Import of official release files as splits: merges languages, and adds objects and sections."""

import logging
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from pathlib import Path

import numpy as np

import arramon_lang as lang
from arramon_dataset.parallel import process_pool, processes_of
from arramon_dataset.release.files import read_release
from arramon_dataset.release.landmarks.rebuilt_section import rebuild_section
from arramon_dataset.release.missing_objects import (
    ObjectReference,
    Points,
    arrange_decoys,
    draw_distracters,
    read_references,
)
from arramon_dataset.release.reconstruction import reconstruct_section
from arramon_lang.meaning import Assembly
from arramon_server.episodes.episode import Episode, with_languages
from arramon_server.episodes.provenance import Provenance, origins_of
from arramon_server.episodes.splits import Split, read_split, split_folder, write_split
from arramon_server.errors import BadFile, BadInput
from arramon_server.sim.own_furniture import OwnFurniture
from arramon_server.sim.room import RoomPosition
from arramon_server.sim.rules import Collectible, PlacedObject, moved
from arramon_server.sim.section import Section

SOURCE = "imported from the official release's format"

EPISODES_A_PROCESS = 40
"""Minimum number of episodes per process, as a process takes about two seconds to start."""

Rebuilt = tuple[Section, Sequence[Episode], Provenance]
"""A section with its furniture, its episodes with theirs, and where both come from."""

_log = logging.getLogger(__name__)


def import_release(
    files: Sequence[Path],
    data: Path,
    *,
    split: str | None = None,
    language: str | None = None,
    hidden: bool = False,
    jobs: int = 0,
) -> list[Split]:
    """Import release files into the data folder.

    If an episode's `mapId` exists already, in the data folder or in another file, the file's language is added to it.
    Nothing is written unless all files are valid.

    Args:
        files: in the release's format, in any languages.
        data: the data folder.
        split: name of the split; None to derive it from each file's name (`val_seen.json`, `val_seen_hindi.json`).
        language: code of the language of all files; None to detect it from each file's texts.
        hidden: whether targets, goals and paths must never leave the server.
        jobs: number of processes; 0 for one per core, one where there is little to do. The result is the same.

    Returns:
        The splits that were written.

    Raises:
        BadFile: if a file is invalid, or contradicts another of the same split.
        BadInput: if the language is unknown, a split of that name was not imported, or `jobs` is out of range.
        StorageError: if the data folder cannot be written.
    """
    if language is not None and language not in lang.available():
        raise BadInput(f"there is no language {language!r}; there are {', '.join(lang.available())}")
    processes = processes_of(jobs)
    gathered: dict[str, dict[str, Episode]] = {}
    for file in files:
        name = split or split_name(file)
        if name not in gathered:
            gathered[name] = _existing_episodes(data, name)
        spoken, episodes = read_release(file, language)
        _merge(gathered[name], episodes, spoken, file)
    return [_write(data, name, episodes.values(), hidden, processes) for name, episodes in gathered.items()]


def split_name(file: Path) -> str:
    """Return the split of a release file: the file's name without extension and language."""
    name = file.stem
    for code in lang.available():
        name = name.removesuffix(f"_{lang.load(code).english_name.lower()}").removesuffix(f"_{code}")
    return name


def _existing_episodes(data: Path, name: str) -> dict[str, Episode]:
    """Return the existing episodes of a split, reduced to what the release contains."""
    folder = split_folder(data, name)
    if not folder.exists():
        return {}
    split = read_split(folder)
    if split.source != SOURCE:
        raise BadInput(f"split {name!r} exists and was not imported; choose another name with --split")
    return {episode_id: _bare(episode) for episode_id, episode in split.episodes.items()}


def _bare(episode: Episode) -> Episode:
    first, second = (replace(turn, street=turn.street[:1]) for turn in episode.turns)
    return replace(episode, turns=(first, second), decoys=(), furniture=OwnFurniture())


def _merge(episodes: dict[str, Episode], more: Iterable[Episode], language: str, file: Path) -> None:
    for episode in more:
        known = episodes.get(episode.episode_id)
        if known is None:
            episodes[episode.episode_id] = episode
            continue
        if (known.turns, known.start) != (episode.turns, episode.start):
            raise BadFile(file, f"mapId {episode.episode_id} has other paths or targets than in an earlier file")
        if known.instructions.get(language, episode.instructions[language]) != episode.instructions[language]:
            raise BadFile(file, f"mapId {episode.episode_id} has other {language!r} instructions than already imported")
        episodes[episode.episode_id] = with_languages(known, episode.instructions)


def _write(data: Path, name: str, episodes: Collection[Episode], hidden: bool, processes: int) -> Split:
    by_section: dict[str, list[Episode]] = {}
    for episode in sorted(episodes, key=lambda episode: int(episode.episode_id)):
        by_section.setdefault(episode.section, []).append(episode)
    episodes_written: list[Episode] = []
    sections, provenance = [], []
    for rebuilt, furnished, origins in _rebuild_all(by_section, min(processes, len(episodes) // EPISODES_A_PROCESS)):
        episodes_written += furnished
        sections.append(rebuilt)
        provenance.append(origins)
    counts = origins_of(provenance, {section.id: section for section in sections})
    summary = str(counts) or "no furniture"
    _log.info("split %s: %d episodes in %d sections; %s", name, len(episodes_written), len(sections), summary)
    return write_split(
        data, name, hidden=hidden, source=SOURCE, episodes=episodes_written, sections=sections, provenance=provenance
    )


def _rebuild_all(by_section: Mapping[str, Sequence[Episode]], processes: int) -> Iterator[Rebuilt]:
    """Yield the sections in their order, rebuilt on several cores."""
    if processes < 2 or len(by_section) < 2:
        yield from map(_rebuild, by_section, by_section.values())
        return
    with process_pool(min(processes, len(by_section)), "rebuilds sections") as pool:
        yield from pool.map(_rebuild, by_section, by_section.values())


def _rebuild(section: str, episodes: Sequence[Episode]) -> Rebuilt:
    ground = walked_positions(episodes)
    with_objects = [add_objects(episode, ground) for episode in episodes]
    return rebuild_section(_section(section, with_objects), with_objects)


def _section(section: str, episodes: Sequence[Episode]) -> Section:
    turns = [turn for episode in episodes for turn in episode.turns]
    targets = np.array([(turn.target.position.x, turn.target.position.z) for turn in turns])
    return reconstruct_section(section, [np.array(turn.path) for turn in turns], targets)


def walked_positions(episodes: Sequence[Episode]) -> Points:
    """Return all positions on paths in a section, (m, 2)."""
    ground: Points = np.unique(np.concatenate([np.array(t.path) for e in episodes for t in e.turns]).round(2), axis=0)
    return ground


def add_objects(episode: Episode, ground: Points) -> Episode:
    """Return the episode with distracters and decoys, seeded by its id.

    Args:
        episode: as in the release.
        ground: (m, 2) of (x, z), positions on the paths of its section.
    """
    pose, turns = episode.start, []
    for number, turn in enumerate(episode.turns, start=1):
        pose = reduce(moved, turn.actions, pose)
        others = draw_distracters(
            episode.episode_id, number, turn.target.type, turn.target.position, np.array(turn.path), pose, ground
        )
        turns.append(replace(turn, street=(turn.target, *(Collectible(*other) for other in others))))
    first, second = turns
    room = arrange_decoys(
        episode.episode_id,
        (first.target.type, second.target.type),
        (first.target_cell, second.target_cell),
        (first.room_path, second.room_path),
        _references(episode),
        _meanings(episode),
    )
    placed = tuple(PlacedObject(kind, RoomPosition(cell.column, 1, cell.row)) for kind, cell in room)
    return replace(episode, turns=(first, second), decoys=placed)


def _references(episode: Episode) -> tuple[tuple[ObjectReference, ...], tuple[ObjectReference, ...]]:
    """Return the objects mentioned in both assembly instructions, in the first language by code: English if present."""
    code = min(episode.instructions)
    first, second = (read_references(text.assembly, lang.load(code)) for text in episode.instructions[code])
    return first, second


def _meanings(episode: Episode) -> tuple[Assembly | None, Assembly | None]:
    """Return the meanings of both assembly instructions, in the same language; None for one that cannot be read."""
    code = min(episode.instructions)
    first, second = (_meaning(text.assembly, lang.load(code)) for text in episode.instructions[code])
    return first, second


def _meaning(text: str, language: lang.Language) -> Assembly | None:
    try:
        meaning = language.read(text, "assembly")
    except lang.CannotRead:
        return None
    assert isinstance(meaning, Assembly)  # Reading an assembly instruction gives nothing else.
    return meaning

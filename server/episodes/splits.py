"""Splits in the data folder: `splits/NAME/episodes.jsonl`, `sections/ID.json` and `provenance/ID.json` beside it.

A split's folder is self-contained, sections included, so that one hash identifies the data that a score belongs to.
"""

import hashlib
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from arramon_client.world import DEFAULT_SENSORS, SENSORS
from arramon_server.episodes.demands import Demands, read_demands
from arramon_server.episodes.episode import Episode, languages_of
from arramon_server.episodes.instruction_texts import TextSummary, texts_by_language
from arramon_server.episodes.provenance import Provenance
from arramon_server.episodes.split_files import (
    EPISODE_FORMAT,
    EpisodeFileHeader,
    lowest_version,
    read_bytes,
    read_episodes,
    read_provenance,
    read_section,
    write_episodes,
    write_provenance,
    write_section,
)
from arramon_server.errors import BadFile, NotFound, StorageError
from arramon_server.sim.section import Section

ROOMS_SPLIT = "rooms"
"""The split of tasks in the room alone, without a city."""

EPISODES_FILE = "episodes.jsonl"
"""The file of a split's episodes, in its folder."""

SECRET_FILE = "secret"  # noqa: S105 - a file's name
"""The file of the host's secret, in the data folder."""


@dataclass(frozen=True, eq=False)
class Split:
    """A named set of episodes and their sections.

    Attributes:
        name: name, such as "val_seen".
        hidden: whether targets, goals and paths must never leave the server.
        source: origin of the episodes, as free text.
        episodes: episodes by id.
        sections: sections by id.
        data_hash: SHA-256 of the names and contents of all its files, in hexadecimal.
        training: whether it is for training alone, and runs on it are not ranked.
        provenance: provenance of recovered furniture, by section; empty if none was recovered.
        demands: demands of the instructions, by episode; empty if unknown.
    """

    name: str
    hidden: bool
    source: str
    episodes: Mapping[str, Episode]
    sections: Mapping[str, Section]
    data_hash: str
    training: bool = False
    provenance: Mapping[str, Provenance] = field(default_factory=dict)
    demands: Demands = field(default_factory=dict)

    @property
    def sensors(self) -> tuple[str, ...]:
        """The sensors that a run on this split may request."""
        return DEFAULT_SENSORS if self.hidden else SENSORS

    @property
    def languages(self) -> dict[str, int]:
        """Number of episodes with instructions in each language, by code."""
        return languages_of(self.episodes.values())

    @cached_property
    def texts(self) -> Mapping[str, TextSummary]:
        """Alphabet and lengths of the instructions in each language, by code."""
        return texts_by_language(self.episodes.values())

    @cached_property
    def truth_hash(self) -> bytes:
        """SHA-256 of the ground truth, 32 bytes. Unlike `data_hash` it is secret: only owners of the split know it.

        The shown scores of a hidden split are derived from it, so its definition must never change.
        """
        digest = hashlib.sha256(b"arramon truth 1\n")
        for episode_id, episode in sorted(self.episodes.items()):
            for turn in episode.turns:
                place, cell = turn.target.position, turn.target_cell
                actions = "".join(str(int(action)) for action in (*turn.actions, *turn.room_actions))
                truth = (episode_id, place.x, place.y, place.z, cell.column, cell.level, cell.row, actions)
                digest.update(f"{truth!r}\n".encode())
        return digest.digest()

    def in_playing_order(self, *languages: str) -> list[Episode]:
        """Return the episodes in any of `languages` in a fixed shuffled order, so that any prefix is a fair sample."""
        with_language = [one for one in self.episodes.values() if not one.instructions.keys().isdisjoint(languages)]
        return sorted(with_language, key=lambda episode: hashlib.sha256(episode.episode_id.encode()).digest())


def split_folder(data: Path, name: str) -> Path:
    """Return the folder of a split in the data folder."""
    return data / "splits" / name


def split_folders(data: Path) -> list[Path]:
    """Return the folders of all splits, sorted by name, without temporary folders left by a killed `write_split`."""
    return sorted(folder for folder in (data / "splits").glob("*/") if not folder.name.startswith("."))


def read_splits(data: Path) -> dict[str, Split]:
    """Read all splits of a data folder, by name.

    Raises:
        BadFile: if a file is invalid.
        NotFound: if there is no split; the message says how to make one.
    """
    folders = split_folders(data)
    if not folders:
        raise no_splits_error(data)
    return {folder.name: read_split(folder) for folder in folders}


def no_splits_error(data: Path) -> NotFound:
    """Return the error for a data folder without splits, which says how to get one."""
    return NotFound(
        f"there are no episodes in {data}; make some with `arramon-server generate --data {data}`, "
        f"or import some with `arramon-server import-release FILE... --data {data}`"
    )


def check_split(splits: Mapping[str, Split], name: str | None) -> None:
    """Check that the split with a name, if given, exists.

    Raises:
        NotFound: if it does not; the message lists the existing splits.
    """
    if name is not None and name not in splits:
        raise NotFound(f"there is no split {name!r}; there are {', '.join(splits)}")


def read_named_split(data: Path, name: str) -> Split:
    """Read the split of a name.

    Raises:
        NotFound: if there is no such split; the message lists the existing ones, or says how to make one.
        BadFile: if a file is invalid.
    """
    folders = {folder.name: folder for folder in split_folders(data)}
    if not folders:
        raise no_splits_error(data)
    if name not in folders:
        raise NotFound(f"there is no split {name!r} in {data}; there are {', '.join(folders)}")
    return read_split(folders[name])


def split_with_episode(splits: Mapping[str, Split], episode_id: str, name: str | None) -> Split:
    """Return the split of a name, or the first one that has an episode if the name is None.

    Raises:
        NotFound: if there is no such split or no such episode.
    """
    check_split(splits, name)
    for split in splits.values():
        if name in (None, split.name) and episode_id in split.episodes:
            return split
    raise NotFound(f"there is no episode {episode_id!r} in {name or ', '.join(splits)}")


def read_split(folder: Path) -> Split:
    """Read one split.

    Raises:
        BadFile: if a file is invalid, or the section of an episode is missing.
    """
    header, episodes = read_episodes(folder / EPISODES_FILE)
    if header.split != folder.name:
        raise BadFile(
            folder / EPISODES_FILE, f"is {header.split!r}, but the folder is {folder.name!r}", line=1, field="split"
        )
    sections = {path.stem: read_section(path) for path in sorted((folder / "sections").glob("*.json"))}
    for line, episode in enumerate(episodes, start=2):
        if episode.section not in sections:
            problem = f"is {episode.section!r}; there are {', '.join(sections) or 'none'} in {folder / 'sections'}"
            raise BadFile(folder / EPISODES_FILE, problem, line=line, field="section")
        try:
            episode.furniture.check(sections[episode.section])
        except ValueError as error:
            raise BadFile(folder / EPISODES_FILE, str(error), line=line, field="furniture") from error
    by_id = {episode.episode_id: episode for episode in episodes}
    data_hash = split_hash(folder)
    return Split(
        header.split,
        header.hidden,
        header.source,
        by_id,
        sections,
        data_hash,
        header.training,
        _read_provenance(folder, sections, by_id),
        read_demands(folder, data_hash),
    )


def _read_provenance(
    folder: Path, sections: Mapping[str, Section], episodes: Mapping[str, Episode]
) -> dict[str, Provenance]:
    found = {}
    for path in sorted((folder / "provenance").glob("*.json")):
        provenance = read_provenance(path)
        if provenance.section != path.stem or path.stem not in sections:
            problem = f"is {provenance.section!r}; expected {path.stem!r}, and a section of that id"
            raise BadFile(path, problem, field="section")
        try:
            provenance.check(sections[path.stem], episodes)
        except ValueError as error:
            raise BadFile(path, str(error)) from error
        found[path.stem] = provenance
    return found


def write_split(
    data: Path,
    name: str,
    *,
    hidden: bool,
    source: str,
    episodes: Iterable[Episode],
    sections: Iterable[Section],
    training: bool = False,
    provenance: Iterable[Provenance] = (),
) -> Split:
    """Write a split and read it back. An existing split is replaced only once the new one is complete.

    Raises:
        StorageError: if the folder cannot be written.
    """
    folder, listed = split_folder(data, name), list(episodes)
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".new-") as temporary:
            new = Path(temporary) / name
            (new / "sections").mkdir(parents=True)
            if hidden:
                new.chmod(0o700)  # Targets, goals and paths stay private to the owner on this machine, too.
            header = EpisodeFileHeader(EPISODE_FORMAT, lowest_version(listed), name, hidden, source, training)
            write_episodes(new / "episodes.jsonl", header, listed)
            for section in sections:
                write_section(new / "sections" / f"{section.id}.json", section)
            for each in provenance:
                (new / "provenance").mkdir(exist_ok=True)
                write_provenance(new / "provenance" / f"{each.section}.json", each)
            split = read_split(new)
            if folder.exists():
                shutil.move(folder, Path(temporary) / "old")
            new.rename(folder)
    except OSError as error:
        raise StorageError(f"cannot write to {folder}: {error.strerror}") from error
    return split


def split_hash(folder: Path) -> str:
    """The SHA-256 over names and bytes of all files in a split's folder, in hexadecimal."""
    digest = hashlib.sha256()
    files = [path for name in ("sections", "provenance") for path in sorted((folder / name).glob("*.json"))]
    for path in [folder / EPISODES_FILE, *files]:
        data = read_bytes(path)
        digest.update(f"{path.relative_to(folder).as_posix()} {len(data)}\n".encode())
        digest.update(data)
    return digest.hexdigest()

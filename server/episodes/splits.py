"""The data folder: `splits/NAME/episodes.jsonl` and `splits/NAME/sections/ID.json`.

A split is whole in its own folder, sections included, so that one hash says which world a score was reached in.
"""

import hashlib
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from server.episodes.episode import Episode, languages_of
from server.episodes.files import (
    FORMAT,
    VERSION,
    Header,
    read_bytes,
    read_episodes,
    read_section,
    write_episodes,
    write_section,
)
from server.errors import BadFile, NotFound, StorageError
from server.sim.section import Section

SENSORS = ("rgb", "depth", "segmentation", "pose", "oracle")
"""Everything an agent can be given. A hidden split offers only the first two: a segmentation names what is seen."""


@dataclass(frozen=True, eq=False)
class Split:
    """Episodes that belong together, and the sections that they take place in.

    Attributes:
        name: such as "val_seen".
        hidden: whether targets, goals and paths must never leave the server.
        source: where the episodes came from, in words.
        episodes: by id.
        sections: by id.
        data_hash: SHA-256 over the names and bytes of all its files, in hexadecimal.
    """

    name: str
    hidden: bool
    source: str
    episodes: Mapping[str, Episode]
    sections: Mapping[str, Section]
    data_hash: str

    @property
    def sensors(self) -> tuple[str, ...]:
        """What a run on this split may ask for."""
        return SENSORS[:2] if self.hidden else SENSORS

    @property
    def languages(self) -> dict[str, int]:
        """How many episodes hold instructions in each language."""
        return languages_of(self.episodes.values())

    def in_playing_order(self, language: str) -> list[Episode]:
        """The episodes in `language`, shuffled once and for all, so that the first few are a fair sample."""
        spoken = [episode for episode in self.episodes.values() if language in episode.instructions]
        return sorted(spoken, key=lambda episode: hashlib.sha256(episode.episode_id.encode()).digest())


def folder_of(data: Path, name: str) -> Path:
    """Where a split lies in the data folder."""
    return data / "splits" / name


def folders_of(data: Path) -> list[Path]:
    """The folders of all splits, in the order of their names; not what a killed `write_split` left behind."""
    return sorted(folder for folder in (data / "splits").glob("*/") if not folder.name.startswith("."))


def read_splits(data: Path) -> dict[str, Split]:
    """All splits of a data folder, by name.

    Raises:
        BadFile: if a file is wrong.
        NotFound: if there is no split at all; the message says how to get one.
    """
    folders = folders_of(data)
    if not folders:
        raise NotFound(
            f"there are no episodes in {data}; make some with `arramon-server generate --data {data}`, "
            f"or bring some in with `arramon-server import-release FILE... --data {data}`"
        )
    return {folder.name: read_split(folder) for folder in folders}


def read_split(folder: Path) -> Split:
    """One split.

    Raises:
        BadFile: if a file is wrong, or a section that an episode needs is not there.
    """
    header, episodes = read_episodes(folder / "episodes.jsonl")
    if header.split != folder.name:
        raise BadFile(
            folder / "episodes.jsonl", f"is {header.split!r}, but the folder is {folder.name!r}", line=1, field="split"
        )
    sections = {path.stem: read_section(path) for path in sorted((folder / "sections").glob("*.json"))}
    for line, episode in enumerate(episodes, start=2):
        if episode.section not in sections:
            problem = f"is {episode.section!r}; there are {', '.join(sections) or 'none'} in {folder / 'sections'}"
            raise BadFile(folder / "episodes.jsonl", problem, line=line, field="section")
    by_id = {episode.episode_id: episode for episode in episodes}
    return Split(header.split, header.hidden, header.source, by_id, sections, _hash(folder))


def write_split(
    data: Path, name: str, *, hidden: bool, source: str, episodes: Iterable[Episode], sections: Iterable[Section]
) -> Split:
    """Writes a split and reads it back; one that was there before is replaced only when the new one is whole.

    Raises:
        StorageError: if the folder cannot be written.
    """
    folder = folder_of(data, name)
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".new-") as temporary:
            new = Path(temporary) / name
            (new / "sections").mkdir(parents=True)
            if hidden:
                new.chmod(0o700)  # Targets, goals and paths are its owner's alone on this machine, too.
            write_episodes(new / "episodes.jsonl", Header(FORMAT, VERSION, name, hidden, source), episodes)
            for section in sections:
                write_section(new / "sections" / f"{section.id}.json", section)
            split = read_split(new)
            if folder.exists():
                shutil.move(folder, Path(temporary) / "old")
            new.rename(folder)
    except OSError as error:
        raise StorageError(f"cannot write to {folder}: {error.strerror}") from error
    return split


def _hash(folder: Path) -> str:
    digest = hashlib.sha256()
    for path in [folder / "episodes.jsonl", *sorted((folder / "sections").glob("*.json"))]:
        data = read_bytes(path)
        digest.update(f"{path.relative_to(folder).as_posix()} {len(data)}\n".encode())
        digest.update(data)
    return digest.hexdigest()

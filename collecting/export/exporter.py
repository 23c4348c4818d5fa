"""Export of the kept texts of collections: a split in the project's format, and files in the official release's."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from arramon_collecting.export.provenance import FILE, exported_collections, provenance_of, provenance_of_several
from arramon_collecting.export.release_file import is_numbered, write_release
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.texts.records import KEPT, Text
from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.provenance import Provenance
from arramon_server.episodes.splits import Split, split_folder, write_split
from arramon_server.errors import BadInput, Conflict, NotFound, StorageError


@dataclass(frozen=True, slots=True)
class Exported:
    """Exported collections.

    Attributes:
        split: the split.
        folder: its folder.
        releases: the files in the release's form, one for each language; empty if the episodes' ids are no numbers.
        left_out: number of texts of the collections that were not kept.
    """

    split: Split
    folder: Path
    releases: tuple[Path, ...]
    left_out: int


def export_collections(store: Store, collections: Sequence[Collection], base: Split, data: Path, name: str) -> Exported:
    """Write the kept texts as a split, with `collection.json` beside its episodes.

    The episodes keep their ids and ground truth; they have the collected texts only. Each collection gives those of its
    language; an episode for which one of them has kept no text lacks that language.

    Args:
        store: storage of the collections.
        collections: the collections, which were written for the same split, each in another language.
        base: that split.
        data: the data folder.
        name: name of the new split. An earlier export of the same collections is replaced.

    Raises:
        BadInput: if two collections have the same language, or are not of the same split.
        NotFound: if a collection has kept no text.
        Conflict: if there is another split of that name, or the base split lacks an episode.
        StorageError: if the folder cannot be written.
    """
    _check_together(collections)
    folder, names = split_folder(data, name), [one.name for one in collections]
    if folder.exists() and exported_collections(folder) != set(names):
        these = "this collection" if len(names) == 1 else f"{' and '.join(names)} together"
        raise Conflict(f"there is a split {name!r} already, and it is no export of {these}; use --split NAME")
    kept = {one.language: store.texts.all(one.name, KEPT) for one in collections}
    for one in collections:
        if not kept[one.language]:
            raise NotFound(f"no text of collection {one.name!r} was kept yet; `collect status` shows how it stands")
    episodes = _episodes(base, kept)
    sections = [base.sections[one] for one in sorted({episode.section for episode in episodes})]
    of = "; ".join(f"{one.name}, {one.language}, {one.settings.licence}" for one in collections)
    split = write_split(
        data,
        name,
        hidden=base.hidden,
        source=f"collected from people: {of}; episodes of {base.name}: {base.source}",
        episodes=episodes,
        sections=sections,
        training=base.training,
        provenance=_provenance(base, episodes, {section.id for section in sections}),
    )
    described = [_description(store, one, kept[one.language], split) for one in collections]
    description = described[0] if len(described) == 1 else provenance_of_several(described)
    try:
        (folder / FILE).write_text(json.dumps(description, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
        releases = tuple(_releases(folder, name, collections, episodes))
    except OSError as error:
        raise StorageError(f"cannot write to {folder}: {error.strerror}") from error
    texts = sum(sum(store.texts.counts(one.name).values()) for one in collections)
    return Exported(split, folder, releases, texts - sum(map(len, kept.values())))


def _check_together(collections: Sequence[Collection]) -> None:
    first, *others = collections
    for one in others:
        if one.split != first.split:
            raise BadInput(
                f"collection {first.name!r} is of the split {first.split!r}, and {one.name!r} of {one.split!r}; "
                "expected collections of one split"
            )
    languages = [one.language for one in collections]
    for language in languages:
        if languages.count(language) > 1:
            raise BadInput(f"several collections are in {language!r}; expected one for each language")


def _description(store: Store, collection: Collection, texts: Sequence[Text], split: Split) -> dict[str, Any]:
    tasks = {task.task_id: task for task in store.tasks.all(collection.name)}
    verifications = store.verifications.all(collection.name)
    counts = store.texts.counts(collection.name)
    return provenance_of(
        collection, texts, tasks, verifications, split=split.name, data_hash=split.data_hash, counts=counts
    )


def _releases(folder: Path, name: str, collections: Sequence[Collection], episodes: Sequence[Episode]) -> list[Path]:
    """Write the files in the release's form, which has one language each."""
    if not is_numbered(episodes):
        return []
    written = []
    for one in collections:
        end = "release.json" if len(collections) == 1 else f"{one.language}.release.json"
        there = [episode for episode in episodes if one.language in episode.instructions]
        write_release(folder / f"{name}.{end}", there, one.language, one.name)
        written.append(folder / f"{name}.{end}")
    return written


def _episodes(base: Split, kept: Mapping[str, Sequence[Text]]) -> list[Episode]:
    """Return the episodes that have texts, in the order of the base split, with the texts of each language."""
    found: dict[str, dict[str, tuple[Instructions, Instructions]]] = {}
    for language, texts in kept.items():
        for text in texts:
            first, second = (Instructions(*pair) for pair in text.instructions)
            found.setdefault(text.episode_id, {})[language] = (first, second)
    if missing := found.keys() - base.episodes.keys():
        raise Conflict(f"the split {base.name!r} has no episode {min(missing)!r} any more")
    return [
        replace(episode, instructions=found[episode.episode_id])
        for episode in base.episodes.values()
        if episode.episode_id in found
    ]


def _provenance(base: Split, episodes: Sequence[Episode], sections: set[str]) -> list[Provenance]:
    """Return the provenance of the furniture of these sections and episodes."""
    there = {episode.episode_id for episode in episodes}
    return [
        replace(one, own={key: origins for key, origins in one.own.items() if key in there})
        for one in base.provenance.values()
        if one.section in sections
    ]

"""Export of the kept texts of a collection: a split in the project's format, and a file in the official release's."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from arramon_collecting.export.provenance import FILE, provenance_of
from arramon_collecting.export.release_file import is_numbered, write_release
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.texts.records import KEPT, Text
from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.provenance import Provenance
from arramon_server.episodes.splits import Split, split_folder, write_split
from arramon_server.errors import Conflict, NotFound, StorageError


@dataclass(frozen=True, slots=True)
class Exported:
    """An exported collection.

    Attributes:
        split: the split.
        folder: its folder.
        release: the file in the release's form; None if the episodes' ids are no numbers.
        left_out: number of texts of the collection that were not kept.
    """

    split: Split
    folder: Path
    release: Path | None
    left_out: int


def export_collection(store: Store, collection: Collection, base: Split, data: Path, name: str) -> Exported:
    """Write the kept texts as a split, with `collection.json` beside its episodes.

    The episodes keep their ids and ground truth; they have the collected texts only, in the collection's language.

    Args:
        store: storage of the collections.
        collection: the collection.
        base: the split that was written for.
        data: the data folder.
        name: name of the new split. An earlier export of the same collection is replaced.

    Raises:
        NotFound: if no text was kept.
        Conflict: if there is another split of that name, or the base split lacks an episode.
        StorageError: if the folder cannot be written.
    """
    folder = split_folder(data, name)
    if folder.exists() and not _is_export_of(folder, collection):
        raise Conflict(f"there is a split {name!r} already, and it is no export of this collection; use --split NAME")
    texts, counts = store.texts.all(collection.name, KEPT), store.texts.counts(collection.name)
    if not texts:
        raise NotFound(f"no text of collection {collection.name!r} was kept yet; `collect status` shows how it stands")
    episodes = _episodes(base, texts, collection.language)
    sections = [base.sections[one] for one in sorted({episode.section for episode in episodes})]
    split = write_split(
        data,
        name,
        hidden=base.hidden,
        source=f"collected from people: {collection.name}, {collection.language}, {collection.settings.licence}; "
        f"episodes of {base.name}: {base.source}",
        episodes=episodes,
        sections=sections,
        training=base.training,
        provenance=_provenance(base, episodes, {section.id for section in sections}),
    )
    tasks = {task.task_id: task for task in store.tasks.all(collection.name)}
    verifications = store.verifications.all(collection.name)
    description = provenance_of(
        collection, texts, tasks, verifications, split=name, data_hash=split.data_hash, counts=counts
    )
    try:
        (folder / FILE).write_text(json.dumps(description, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
        release = folder / f"{name}.release.json" if is_numbered(episodes) else None
        if release is not None:
            write_release(release, episodes, collection.language, collection.name)
    except OSError as error:
        raise StorageError(f"cannot write to {folder}: {error.strerror}") from error
    return Exported(split, folder, release, sum(counts.values()) - len(texts))


def _episodes(base: Split, texts: Sequence[Text], language: str) -> list[Episode]:
    """Return the episodes of the texts, in the order of the base split."""
    by_episode: Mapping[str, Text] = {text.episode_id: text for text in texts}
    if missing := by_episode.keys() - base.episodes.keys():
        raise Conflict(f"the split {base.name!r} has no episode {min(missing)!r} any more")
    found = []
    for episode in base.episodes.values():
        if (text := by_episode.get(episode.episode_id)) is not None:
            first, second = (Instructions(*pair) for pair in text.instructions)
            found.append(replace(episode, instructions={language: (first, second)}))
    return found


def _provenance(base: Split, episodes: Sequence[Episode], sections: set[str]) -> list[Provenance]:
    """Return the provenance of the furniture of these sections and episodes."""
    there = {episode.episode_id for episode in episodes}
    return [
        replace(one, own={key: origins for key, origins in one.own.items() if key in there})
        for one in base.provenance.values()
        if one.section in sections
    ]


def _is_export_of(folder: Path, collection: Collection) -> bool:
    try:
        content = json.loads((folder / FILE).read_text("utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(content, dict) and content.get("collection") == collection.name

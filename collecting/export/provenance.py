"""Provenance of collected texts: `collection.json` in the folder of an exported split."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from arramon_collecting.rules.keeping import Outcome, succeeded
from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.texts.records import Text, Verification
from arramon_collecting.storage.work.records import REVIEW, WRITE, Task
from arramon_server import __version__

FILE = "collection.json"

FORMAT, VERSION = "arramon-collection", 1
"""Header of the file."""

_COMMON = ("format", "version", "server_version", "from_split", "split", "data_hash")
"""What the collections of one export have in common."""


def provenance_of(
    collection: Collection,
    texts: Sequence[Text],
    tasks: Mapping[str, Task],
    verifications: Sequence[Verification],
    *,
    split: str,
    data_hash: str,
    counts: Mapping[str, int],
) -> dict[str, Any]:
    """Return the provenance of exported texts as JSON data. Persons are pseudonyms; there are no times of day.

    Args:
        collection: the collection.
        texts: the exported texts.
        tasks: the tasks in which texts were written, by id.
        verifications: all verifications of the collection.
        split: name of the exported split.
        data_hash: hash of its data.
        counts: number of texts of the collection in each state.
    """
    by_text: dict[str, list[Verification]] = {}
    for one in verifications:
        if one.text_id is not None and one.counts:
            by_text.setdefault(one.text_id, []).append(one)
    settings = collection.settings
    rule = ("verifiers", "keep_ndtw", "keep_ptc", "keep_needs")
    return {
        "format": FORMAT,
        "version": VERSION,
        "server_version": __version__,
        "collection": collection.name,
        "kind": collection.kind,
        "language": collection.language,
        "from_split": collection.split,
        "split": split,
        "data_hash": data_hash,
        "licence": settings.licence,
        "consent_sha256": collection.consent_hash,
        "consent_sha256_in": {
            code: settings.consent_shown(code).hash_with(settings.licence) for code in sorted(settings.consents)
        },
        "created_on": f"{collection.created_at:%Y-%m-%d}",
        "rule": {name: getattr(settings, name) for name in rule},
        "texts_by_state": dict(sorted(counts.items())),
        "texts": [_text(one, tasks, by_text.get(one.text_id, ()), collection) for one in texts],
    }


def provenance_of_several(described: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the provenance of an export of several collections: what they have in common, then each in `collections`.

    Args:
        described: the provenance of each, as `provenance_of` returns it.
    """
    common = {key: described[0][key] for key in _COMMON}
    return {**common, "collections": [{k: v for k, v in one.items() if k not in _COMMON} for one in described]}


def exported_collections(folder: Path) -> set[str]:
    """Return the names of the collections of which a split's folder is an export; empty if it is none."""
    try:
        content = json.loads((folder / FILE).read_text("utf-8"))
        return {one["collection"] for one in content.get("collections", [content])}
    except (OSError, ValueError, AttributeError, KeyError, TypeError):
        return set()


def _text(
    text: Text, tasks: Mapping[str, Task], verifications: Sequence[Verification], collection: Collection
) -> dict[str, Any]:
    task = tasks.get(text.task_id or "")
    return {
        "episode": text.episode_id,
        "text": text.text_id,
        "stage": REVIEW if text.task_id is None else WRITE,
        "author": text.worker_id,
        "version": text.version,
        "written_on": f"{text.created_at:%Y-%m-%d}",
        "seconds": _rounded(task.measured_seconds) if task is not None else None,
        "reviewed_on": f"{text.reviewed_at:%Y-%m-%d}" if text.reviewed_at is not None else None,
        "reviewed_by": text.reviewed_by,
        "checks": [
            {name: one.get(name) for name in ("turn", "phase", "check", "severity", "message")} for one in text.failures
        ],
        "verifications": [_verification(one, collection) for one in verifications],
    }


def _verification(one: Verification, collection: Collection) -> dict[str, Any]:
    return {
        "worker": one.worker_id,
        "ndtw": list(one.ndtw),
        "ptc": list(one.ptc),
        "succeeded": succeeded(Outcome(one.ndtw, one.ptc), collection.settings),
        "flags": list(one.flags),
        "seconds": _rounded(one.measured_seconds),
    }


def _rounded(seconds: float | None) -> float | None:
    return None if seconds is None else round(seconds, 1)

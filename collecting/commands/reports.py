"""Actions of `collect` that report: status, cost, missing texts of the pages."""

import argparse
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from arramon_collecting.commands.base_split import read_base_split
from arramon_collecting.commands.named_collection import find_collection
from arramon_collecting.review.figures import decided_episodes
from arramon_collecting.rules.payment import cost_of
from arramon_collecting.settings import Settings, settings_in_file
from arramon_collecting.storage.people.records import HOST, WORKER
from arramon_collecting.storage.records import FAILED, QUEUED, REVIEW_KIND, SENDING, Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.storage.texts.records import PRESENT
from arramon_collecting.storage.work.records import OPEN, WRITE
from arramon_collecting.web.texts import missing_texts
from arramon_server.commands.journal import open_journal
from arramon_server.configuration.config import Config
from arramon_server.errors import BadInput, NotFound

NONE_YET = "no collections yet; make one with `arramon-server collect create NAME --split SPLIT --lang LANGUAGE`"
"""Printed where there is no collection."""


def status(arguments: argparse.Namespace) -> None:
    """Print how one collection or all stand."""
    if arguments.workers and arguments.name is None:
        raise BadInput("expected the collection whose workers are listed: collect status NAME --workers")
    config: Config = arguments.settings
    if not config.journal and arguments.name is None and config.data.is_dir() and not _has_journal(config):
        print('{"collections": [], "workers": []}' if arguments.json else NONE_YET)
        return
    with open_journal(config, read_only=True) as database:
        store = Store(database)
        chosen = [find_collection(store, arguments.name)] if arguments.name else store.collections.all()
        found = [_standing(store, one, config.data) for one in chosen]
        workers = _workers(store, chosen[0]) if arguments.workers else []
    if arguments.json:
        print(json.dumps({"collections": found, "workers": workers}, ensure_ascii=False, indent=1))
        return
    for one in found:
        print(*_lines(one), sep="\n")
    if workers:
        print(*_table(workers), sep="\n")
    if not found:
        print(NONE_YET)


def cost(arguments: argparse.Namespace) -> None:
    """Print what a number of kept texts costs."""
    if arguments.texts < 1 or arguments.each < 1 or not 0.0 < arguments.kept <= 1.0:
        raise BadInput("expected at least 1 text, at least 1 text of each writer, and a share kept above 0 and up to 1")
    settings = settings_in_file(arguments.settings_file) if arguments.settings_file is not None else Settings()
    written = round(arguments.texts / arguments.kept)
    total = cost_of(arguments.texts, written, arguments.each, settings)
    print(
        f"{arguments.texts} kept texts of {written} written by {-(-written // arguments.each)} people, "
        f"each followed by {settings.verifiers}: {settings.money(total)}"
    )


def list_missing_texts(arguments: argparse.Namespace) -> int:
    """Print the keys of the pages' texts that a language lacks; return 1 if there are any."""
    missing = missing_texts(arguments.language)
    print(*missing, sep="\n", end="\n" if missing else "")
    return int(bool(missing))


def _has_journal(config: Config) -> bool:
    return Path(config.journal_url.removeprefix("sqlite:///")).exists()


def _standing(store: Store, collection: Collection, data: Path) -> dict[str, Any]:
    tasks = Counter((task.stage, task.state) for task in store.tasks.all(collection.name))
    mails = Counter(mail.state for mail in store.mail.all(collection.name))
    people = store.workers.all(collection.name)
    roles = {role: Counter(one.state for one in people if one.role == role) for role in (WORKER, HOST)}
    return {
        "name": collection.name,
        "kind": collection.kind,
        "language": collection.language,
        "split": collection.split,
        "state": collection.state,
        "episodes": _episodes(store, collection, data),
        "workers": dict(sorted(roles[WORKER].items())),
        "hosts": dict(sorted(roles[HOST].items())),
        "texts": dict(sorted(store.texts.counts(collection.name).items())),
        "tasks": {f"{stage} {state}": number for (stage, state), number in sorted(tasks.items())},
        "owed": collection.settings.money(store.ledger.total(collection.name)),
        "mail": {"waiting": mails[QUEUED] + mails[SENDING], "failed": mails[FAILED]},
    }


def _episodes(store: Store, collection: Collection, data: Path) -> dict[str, int] | None:
    """Return the numbers of episodes, of decided ones, and of those that nobody writes for; None if unknown."""
    texts = store.texts.all(collection.name)
    if collection.kind == REVIEW_KIND:
        number = len(texts)
    elif not (number := collection.settings.episodes):
        try:
            number = len(read_base_split(data, collection.split).episodes)
        except NotFound:
            return None
    taken = {text.episode_id for text in texts if text.state in PRESENT}
    taken |= {task.episode_id for task in store.tasks.all(collection.name) if (task.stage, task.state) == (WRITE, OPEN)}
    free = 0 if collection.kind == REVIEW_KIND else max(0, number - len(taken))
    return {"all": number, "decided": len(decided_episodes(texts, collection.kind)), "free": free}


def _lines(found: dict[str, Any]) -> list[str]:
    head = f"{found['name']}: {found['kind']}, {found['language']}, split {found['split']}, {found['state']}"
    episodes = {"all": "unknown, as the split is not in the data folder"} if found["episodes"] is None else {}
    groups = {"episodes": found["episodes"] or episodes} | {
        name: found[name] for name in ("workers", "hosts", "texts", "tasks")
    }
    lines = [
        f"  {name}: {', '.join(f'{key} {n}' for key, n in group.items()) or 'none'}" for name, group in groups.items()
    ]
    lines.append(f"  owed: {found['owed']}")
    if any(found["mail"].values()):
        lines.append(f"  mail: {found['mail']['waiting']} waiting, {found['mail']['failed']} failed")
    return [head, *lines]


def _table(rows: Sequence[Mapping[str, object]]) -> list[str]:
    """Return rows as lines of aligned columns below their headings."""
    cells = [list(rows[0]), *([str(value) for value in row.values()] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in cells]


def _workers(store: Store, collection: Collection) -> list[dict[str, object]]:
    return [
        {
            "worker": worker.worker_id,
            "role": worker.role,
            "state": worker.state,
            "texts": len(store.texts.all_of(worker.worker_id)),
            "verifications": len(store.verifications.of_worker(worker.worker_id)),
            "owed": collection.settings.money(store.ledger.total_of(worker.worker_id)),
            "external_id": worker.external_id or "-",
            "note": worker.note or "-",
        }
        for worker in store.workers.all(collection.name)
    ]

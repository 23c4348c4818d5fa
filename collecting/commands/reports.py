"""Actions of `collect` that report: status, cost, missing texts of the pages."""

import argparse
import json
from collections import Counter
from typing import Any

from arramon_collecting.rules.payment import cost_of
from arramon_collecting.settings import Settings, settings_in_file
from arramon_collecting.storage.records import FAILED, QUEUED, SENDING, Collection
from arramon_collecting.storage.store import Store
from arramon_collecting.web.texts import missing_texts
from arramon_server.commands.journal import open_journal
from arramon_server.errors import BadInput


def status(arguments: argparse.Namespace) -> None:
    """Print how one collection or all stand."""
    if arguments.workers and arguments.name is None:
        raise BadInput("expected the collection whose workers are listed: collect status NAME --workers")
    with open_journal(arguments.settings, read_only=True) as database:
        store = Store(database)
        chosen = [store.collections.get(arguments.name)] if arguments.name else store.collections.all()
        found = [_standing(store, one) for one in chosen]
        workers = _workers(store, chosen[0]) if arguments.workers else []
    if arguments.json:
        print(json.dumps({"collections": found, "workers": workers}, ensure_ascii=False, indent=1))
        return
    for one in found:
        print(*_lines(one), sep="\n")
    for worker in workers:
        print("  ".join(map(str, worker.values())))
    if not found:
        print("no collections; make one with `arramon-server collect create NAME --split SPLIT --lang LANGUAGE`")


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


def _standing(store: Store, collection: Collection) -> dict[str, Any]:
    tasks = Counter((task.stage, task.state) for task in store.tasks.all(collection.name))
    mails = Counter(mail.state for mail in store.mail.all(collection.name))
    workers = Counter(worker.state for worker in store.workers.all(collection.name))
    return {
        "name": collection.name,
        "kind": collection.kind,
        "language": collection.language,
        "split": collection.split,
        "state": collection.state,
        "workers": dict(sorted(workers.items())),
        "texts": dict(sorted(store.texts.counts(collection.name).items())),
        "tasks": {f"{stage} {state}": number for (stage, state), number in sorted(tasks.items())},
        "owed": collection.settings.money(store.ledger.total(collection.name)),
        "mail": {"waiting": mails[QUEUED] + mails[SENDING], "failed": mails[FAILED]},
    }


def _lines(found: dict[str, Any]) -> list[str]:
    head = f"{found['name']}: {found['kind']}, {found['language']}, split {found['split']}, {found['state']}"
    groups = ((name, found[name]) for name in ("workers", "texts", "tasks"))
    lines = [f"  {name}: {', '.join(f'{key} {n}' for key, n in group.items()) or 'none'}" for name, group in groups]
    lines.append(f"  owed: {found['owed']}")
    if any(found["mail"].values()):
        lines.append(f"  mail: {found['mail']['waiting']} waiting, {found['mail']['failed']} failed")
    return [head, *lines]


def _workers(store: Store, collection: Collection) -> list[dict[str, str]]:
    return [
        {
            "worker": worker.worker_id,
            "role": worker.role,
            "state": worker.state,
            "texts": f"{len(store.texts.all_of(worker.worker_id))} texts",
            "verifications": f"{len(store.verifications.of_worker(worker.worker_id))} verifications",
            "owed": collection.settings.money(store.ledger.total_of(worker.worker_id)),
            "external_id": worker.external_id or "-",
            "note": worker.note or "-",
        }
        for worker in store.workers.all(collection.name)
    ]

"""Actions of `collect` that give out results: the split, the ledger, the visits from a crowd platform."""

import argparse
import csv
import sys
from collections.abc import Iterable, Sequence

from arramon_collecting.commands.base_split import read_base_split
from arramon_collecting.commands.named_collection import find_collection
from arramon_collecting.export.exporter import export_collections
from arramon_collecting.settings import decimal_amount
from arramon_collecting.storage.store import Store
from arramon_server.commands.journal import open_journal
from arramon_server.commands.split_description import describe_split
from arramon_server.configuration.config import Config
from arramon_server.errors import BadInput

LEDGER_COLUMNS = ("worker", "external_id", "kind", "subject", "amount", "currency", "date")
VISIT_COLUMNS = (
    "external_id", "worker", "study", "session", "state", "joined", "completed", "tasks", "last_task", "owed",
    "currency",
)  # fmt: skip


def export(arguments: argparse.Namespace) -> None:
    """Write the kept texts of collections as a split, and in the official release's form."""
    config: Config = arguments.settings
    if arguments.split is None and len(arguments.names) > 1:
        raise BadInput("expected the name of the split for several collections: collect export A B --split NAME")
    name = arguments.split or arguments.names[0]
    if not name or "/" in name or name.startswith("."):
        raise BadInput(f"the split's name is {name!r}, expected the name of a folder")
    with open_journal(config, read_only=True) as database:
        store = Store(database)
        collections = [find_collection(store, one) for one in arguments.names]
        base = read_base_split(config.data, collections[0].split)
        made = export_collections(store, collections, base, config.data, name)
    print(describe_split(made.split))
    print(made.folder / "collection.json")
    print(*made.releases, sep="\n", end="\n" if made.releases else "")
    if not made.releases:
        print("no file in the release's form: the episodes' ids are no numbers", file=sys.stderr)
    print(f"left out: {made.left_out} texts that were not kept", file=sys.stderr)
    for one in collections:
        print(f"beside the paper's figures: arramon-server stats --split {name} --lang {one.language}", file=sys.stderr)


def ledger(arguments: argparse.Namespace) -> None:
    """Print the ledger as CSV."""
    with open_journal(arguments.settings, read_only=True) as database:
        store = Store(database)
        collection = find_collection(store, arguments.name)
        external = {worker.worker_id: worker.external_id or "" for worker in store.workers.all(collection.name)}
        digits = collection.settings.currency_digits
        rows = [
            (
                entry.worker_id,
                external[entry.worker_id],
                entry.kind,
                entry.subject,
                decimal_amount(entry.amount_minor, digits),
                entry.currency,
                f"{entry.created_at:%Y-%m-%d}",
            )
            for entry in store.ledger.entries(collection.name)
        ]
    _print_csv(LEDGER_COLUMNS, rows)


def reconcile(arguments: argparse.Namespace) -> None:
    """Return the tasks of workers who gave up on the platform, and print all visits as CSV."""
    with open_journal(arguments.settings) as database:
        store = Store(database)
        collection = find_collection(store, arguments.name)
        for external_id in arguments.returned:
            worker = store.visits.mark_returned(collection.name, external_id)
            if (task := store.tasks.open_of(worker.worker_id)) is not None:
                store.tasks.give_back(task.task_id)
        rows = [
            (
                one.external_id,
                one.visit.worker_id,
                one.visit.study_id,
                one.visit.session_id,
                one.state,
                f"{one.visit.joined_at:%Y-%m-%dT%H:%M:%SZ}",
                f"{one.visit.completed_at:%Y-%m-%dT%H:%M:%SZ}" if one.visit.completed_at else "",
                one.submitted,
                f"{one.last_at:%Y-%m-%dT%H:%M:%SZ}" if one.last_at else "",
                decimal_amount(one.amount_minor, collection.settings.currency_digits),
                collection.settings.currency,
            )
            for one in store.visits.reconcile(collection.name)
        ]
    _print_csv(VISIT_COLUMNS, rows)


def _print_csv(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print CSV in which no cell is a formula for a spreadsheet: ids come from strangers."""
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow([f"'{cell}" if str(cell).startswith(("=", "+", "-", "@", "\t")) else cell for cell in row])

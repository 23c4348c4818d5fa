"""Actions of `collect` that change a collection: invite, pause, forget, delete."""

import argparse
import sys

from arramon_collecting.commands.named_collection import find_collection
from arramon_collecting.storage.people.records import HOST
from arramon_collecting.storage.records import CLOSED
from arramon_collecting.storage.store import Store
from arramon_collecting.web.texts import texts_of
from arramon_server.commands.journal import open_journal
from arramon_server.configuration.config import Config
from arramon_server.errors import BadInput

MAX_LINKS = 10_000
"""Maximum number of links printed at once."""


def invite(arguments: argparse.Namespace) -> None:
    """Print personal links."""
    config: Config = arguments.settings
    if not 1 <= arguments.count <= MAX_LINKS:
        raise BadInput(f"--count is {arguments.count}; expected 1 to {MAX_LINKS}")
    if arguments.count > 1 and arguments.email:
        raise BadInput("a mail address belongs to one person; expected --count 1")
    site, language = _site(arguments, config), texts_of(arguments.page_lang).language
    with open_journal(config) as database:
        store = Store(database)
        collection = find_collection(store, arguments.name)
        for _ in range(arguments.count):
            stages = () if arguments.role == HOST else arguments.stage
            _, key = store.workers.invite(
                collection, role=arguments.role, stages=stages, note=arguments.note, email=arguments.email
            )
            print(f"{site}/{language}/collect/{collection.name}/join?key={key}")
    print("each link is for one person, and is shown only once", file=sys.stderr)
    if collection.state == CLOSED:
        print(f"the collection is closed and gives out no tasks; `collect resume {collection.name}`", file=sys.stderr)


def set_state(arguments: argparse.Namespace) -> None:
    """Pause, resume or close a collection."""
    with open_journal(arguments.settings) as database:
        store = Store(database)
        changed = store.collections.set_state(find_collection(store, arguments.name).name, arguments.state)
    print(f"collection {changed.name} is {changed.state}")


def forget(arguments: argparse.Namespace) -> None:
    """Delete the data of a worker."""
    with open_journal(arguments.settings) as database:
        store = Store(database)
        collection = find_collection(store, arguments.name)
        worker = store.workers.find(collection, arguments.worker)
        removed = store.removal.forget(collection, worker.worker_id, keep_texts=arguments.keep_texts)
        owed = store.ledger.total_of(worker.worker_id)
        if not database.is_file:
            database.vacuum()
    print(f"deleted: {removed.runs} runs, {removed.texts} texts; kept: {removed.kept_texts} texts")
    if owed:
        print(
            f"the ledger has {collection.settings.money(owed)} for {worker.worker_id}, and nothing else leads to the "
            "person any more: pay what is still owed now, if you know the person",
            file=sys.stderr,
        )
    if removed.kept_texts:
        print(
            f"the texts can be deleted later, too: collect forget {collection.name} {worker.worker_id} --delete-texts",
            file=sys.stderr,
        )
    print(
        "backups and exports made before still have this person's data: delete them, or repeat this command after they "
        "are restored",
        file=sys.stderr,
    )


def delete(arguments: argparse.Namespace) -> None:
    """Delete a collection in which nobody has signed in yet."""
    with open_journal(arguments.settings) as database:
        store = Store(database)
        store.collections.delete(find_collection(store, arguments.name).name)
    print(f"collection {arguments.name} is deleted, with its links")


def _site(arguments: argparse.Namespace, config: Config) -> str:
    if arguments.site is not None:
        if not arguments.site.startswith(("https://", "http://")):
            raise BadInput(f"--site is {arguments.site!r}, expected an address such as https://example.org")
        return str(arguments.site).rstrip("/")
    if not config.web:
        raise BadInput("expected the address of the pages: --site https://example.org, or the setting `web`")
    return config.http["pages"]

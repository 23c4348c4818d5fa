"""Deletion of a person's data: what is gone, what remains, and that nothing is left on the disk."""

from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import pytest
import sqlalchemy as sa

from arramon_collecting.storage.people.records import FORGOTTEN
from arramon_collecting.storage.people.removal import split_of_task
from arramon_collecting.storage.texts.records import KEPT, WITHDRAWN
from arramon_collecting.storage.work.submissions import Play
from arramon_server.errors import Conflict, NotFound
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.collection_tables import COLLECTION_TABLES
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from tests.collecting.collecting import TEXTS, WELL, Field

SECRETS = ("Ann of Pune", "ann@example.org", "PLATFORM-ID-OF-ANN", "pasted-by-ann", "draft-of-ann", "session-of-ann")

MINE = ((TEXTS[0][0], "Put it, in the words of Ann, beside the mug."), TEXTS[1])


def person(field: Field) -> str:
    """Return the id of a worker of whom there is something everywhere."""
    settings = field.collection.settings
    worker = field.store.workers.join(field.collection, SECRETS[2], ("write", "verify"))
    with field.database.write() as connection:
        named = tables.collections[1].update().where(tables.collections[1].c.worker_id == worker.worker_id)
        connection.execute(named.values(note=SECRETS[0]))
    field.store.visits.begin(worker.worker_id, "study", SECRETS[5])
    field.store.workers.set_contact(worker.worker_id, email=SECRETS[1], page_language="en")
    field.store.workers.consent(worker, field.collection, keep_texts=settings.pay_write == 100)
    field.store.sign_ins.open(worker.worker_id)
    worker = field.store.workers.get(worker.worker_id)
    text = field.write(worker, MINE, evidence={"paste": SECRETS[3]}).text
    assert text is not None
    for _ in range(3):
        field.verify(field.worker())
    field.write(field.worker())
    task = field.store.tasks.claim_verify(field.collection, worker, ())
    assert task is not None
    run_id = verification_run(field.database, task.task_id)
    play = Play(run_id, WELL, (1.0, 1.0), (None, None), (((1.25, 2.5),), ()), ("unclear",), 60.0)
    field.store.submissions.submit_verification(field.collection, task, "s", play)
    field.store.drafts.save(field.claim(worker), 0, {"text": SECRETS[4]}, size=20)
    return worker.worker_id


def verification_run(database: Database, task_id: str) -> str:
    """Record a run with a step, as the engine does."""
    run_id, split = "a" * 32, split_of_task("col", task_id)
    key = {"run_id": run_id, "episode_id": "e"}
    run = dict.fromkeys(("participant", "agent", "data_hash", "server_version"), "")
    run |= {"run_id": run_id, "split": split, "language": "en", "state": "COMPLETE"}
    created = datetime(2026, 11, 1, tzinfo=UTC)
    with database.write() as connection:
        connection.execute(tables.runs.insert().values(sensors=[], steps_per_phase=9, created_at=created, **run))
        connection.execute(tables.episodes.insert(), [key | {"ordinal": 0, "state": "X"}])
        connection.execute(tables.steps.insert(), [key | {"step": 0, "action": 1}])
    return run_id


def everything(database: Database) -> str:
    """Return all rows of all tables as text."""
    return "\n".join(str(row) for table in tables.metadata.tables.values() for row in database.read(sa.select(table)))


@pytest.fixture
def field(database_url: str) -> Iterator[Field]:
    platform = {"key": "k", "studies": {"study": {"code": "C"}}}
    made = Field(Database(database_url), smtp={"host": "localhost"}, platform=platform)
    with closing(made.database):
        yield made


def test_only_the_pseudonym_remains(field: Field) -> None:
    worker_id = person(field)
    assert all(secret in everything(field.database) for secret in SECRETS)
    owed, kept = field.store.ledger.total_of(worker_id), field.store.texts.all_of(worker_id)[0]
    removed = field.store.removal.forget(field.collection, worker_id)
    assert (removed.runs, removed.texts, removed.kept_texts) == (1, 0, 1)
    assert not [secret for secret in SECRETS if secret in everything(field.database)]
    worker = field.store.workers.get(worker_id)
    assert (worker.state, worker.consent_hash, worker.device) == (FORGOTTEN, field.collection.consent_hash, {})
    assert worker.consented_at is not None
    assert field.store.ledger.total_of(worker_id) == owed == 130
    text = field.store.texts.get(kept.text_id)
    assert (text.state, text.instructions, text.evidence) == (KEPT, MINE, {})
    (mine,) = field.store.verifications.of_worker(worker_id)
    assert (mine.ndtw, mine.flags, mine.path, mine.run_id) == (WELL, ("unclear",), (), "")
    assert Journal(field.database).runs(9) == []
    assert field.store.tasks.open_of(worker_id) is None


def test_texts_go_too_if_the_person_wants_it(field: Field) -> None:
    worker_id = person(field)
    removed = field.store.removal.forget(field.collection, worker_id, keep_texts=False)
    assert (removed.texts, removed.kept_texts) == (1, 0)
    (text,) = field.store.texts.all_of(worker_id)
    assert (text.state, text.instructions) == (WITHDRAWN, ())


def test_it_is_possible_once_and_for_the_own_collection(field: Field) -> None:
    worker_id = person(field)
    other = field.store.collections.create("other", "write", "en", "sample", field.collection.settings)
    with pytest.raises(NotFound, match="in collection 'other'"):
        field.store.removal.forget(other, worker_id)
    field.store.removal.forget(field.collection, worker_id)
    with pytest.raises(Conflict, match="was deleted already"):
        field.store.removal.forget(field.collection, worker_id)
    with pytest.raises(Conflict, match="the worker is forgotten"):
        field.store.workers.set_state(worker_id, "active")


def test_nothing_is_left_in_the_files_of_sqlite(tmp_path: Path) -> None:
    field = Field(Database(f"sqlite:///{tmp_path / 'journal.db'}"), smtp={"host": "localhost"})
    with closing(field.database):
        worker_id = person(field)
        field.store.removal.forget(field.collection, worker_id, keep_texts=False)
        content = b"".join(path.read_bytes() for path in tmp_path.iterdir())
        assert not [secret for secret in (*SECRETS, "words of Ann") if secret.encode() in content]


def test_a_backup_holds_the_collections_and_what_was_forgotten_is_not_in_it(tmp_path: Path) -> None:
    """One of SQLite; that of PostgreSQL is an export, whose tables are tested in `runs/transfer`."""
    field = Field(Database(f"sqlite:///{tmp_path / 'journal.db'}"), smtp={"host": "localhost"})
    with closing(field.database):
        field.store.removal.forget(field.collection, person(field))
        field.database.copy(tmp_path / "copy.db")
    with closing(Database(f"sqlite:///{tmp_path / 'copy.db'}", read_only=True)) as copy:
        assert all(copy.read(sa.select(table)) for table in COLLECTION_TABLES if table.name == "collection_texts")
        assert not [secret for secret in SECRETS if secret in everything(copy)]

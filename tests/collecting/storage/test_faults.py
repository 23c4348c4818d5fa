"""Faults: a full disk and a lost answer lose nothing, and pay nothing twice."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from sqlalchemy import event

from arramon_collecting.storage.texts.records import VERIFYING
from arramon_collecting.storage.work.records import OPEN
from arramon_collecting.storage.work.submissions import Play
from arramon_server.errors import StorageError
from arramon_server.runs.storage.database import Database
from tests.collecting.collecting import TEXTS, WELL, Field


@contextmanager
def full_disk(database: Database) -> Iterator[None]:
    """Let no connection make the database larger than it is."""

    def limit(connection, _: object) -> None:  # type: ignore[no-untyped-def]
        connection.execute("PRAGMA max_page_count=1")  # SQLite takes the present size if that is more

    database._engine.dispose()
    event.listen(database._engine, "connect", limit)
    try:
        yield
    finally:
        event.remove(database._engine, "connect", limit)
        database._engine.dispose()


@pytest.fixture
def small(tmp_path: Path) -> Iterator[Field]:
    made = Field(Database(f"sqlite:///{tmp_path / 'journal.db'}"), smtp={"host": "localhost"})
    with closing(made.database):
        yield made


PLAY = Play("0" * 32, WELL, (1.0, 1.0), (None, None), ((), ()), (), 60.0)

LONG = (("Turn left. " * 900, TEXTS[0][1]), TEXTS[1])


def test_a_full_disk_refuses_a_submission_whole(small: Field) -> None:
    author = small.worker()
    task = small.claim(author)
    small.store.drafts.save(task, 0, {"text": "saved"}, size=9)
    submit = small.store.submissions.submit_text
    with full_disk(small.database), pytest.raises(StorageError, match="full"):
        submit(small.collection, task, "once", LONG)
    assert small.store.tasks.get(task.task_id).state == OPEN
    assert small.store.drafts.get(task.task_id).body == {"text": "saved"}
    assert (small.owed(author), small.store.texts.all("col")) == (0, [])
    again = submit(small.collection, task, "once", LONG)
    assert (again.repeated, small.owed(author)) == (False, 100)


def test_a_full_disk_leaves_a_draft_as_it_was(small: Field) -> None:
    task = small.claim(small.worker())
    small.store.drafts.save(task, 0, {"text": "first"}, size=9)
    with full_disk(small.database), pytest.raises(StorageError, match="full"):
        small.store.drafts.save(task, 1, {"text": "x" * 50_000}, size=50_010)
    found = small.store.drafts.get(task.task_id)
    assert (found.revision, found.body) == (1, {"text": "first"})
    assert small.store.drafts.save(task, 1, {"text": "x" * 50_000}, size=50_010).revision == 2


def test_a_full_disk_decides_nothing_about_a_text(small: Field) -> None:
    author = small.worker()
    text = small.write(author).text
    assert text is not None
    for _ in range(2):
        small.verify(small.worker())
    last = small.worker()
    task = small.store.tasks.claim_verify(small.collection, last, ())
    assert task is not None
    with full_disk(small.database), pytest.raises(StorageError, match="full"):
        small.verify(last, flags=("x" * 20_000,))
    assert small.store.texts.get(text.text_id).state == VERIFYING
    assert (small.owed(author), small.owed(last)) == (100, 0)
    small.verify(last)
    assert (small.owed(author), small.owed(last)) == (110, 20)


def test_a_forced_repetition_of_every_payment_pays_once(small: Field) -> None:
    """As after a restart in which no client knows which answers it has missed."""
    author, verifiers = small.worker(), [small.worker() for _ in range(3)]
    task = small.claim(author)
    submit = small.store.submissions.submit_text
    assert [submit(small.collection, task, "s", TEXTS).repeated for _ in range(3)] == [False, True, True]
    for verifier in verifiers:
        first = small.verify(verifier)
        repeated = small.store.submissions.submit_verification(small.collection, first.task, first.task.task_id, PLAY)
        assert repeated.repeated
    assert (small.owed(author), [small.owed(one) for one in verifiers]) == (110, [20, 20, 20])
    assert len(small.store.verifications.all("col")) == 3


def test_processes_that_are_killed_leave_what_was_committed(tmp_path: Path) -> None:
    """A second store on the same file is what a restarted server has."""
    url = f"sqlite:///{tmp_path / 'journal.db'}"
    with closing((first := Field(Database(url))).database):
        author = first.worker()
        task = first.claim(author)
        first.store.drafts.save(task, 0, {"text": "आधा"}, size=9)
        with closing(Database(url)) as database:
            second = type(first.store)(database, first.clock)
            assert second.tasks.open_of(author.worker_id) == first.store.tasks.get(task.task_id)
            assert second.drafts.get(task.task_id).body == {"text": "आधा"}
            assert second.submissions.submit_text(first.collection, task, "s", TEXTS).paid
        assert first.store.submissions.submit_text(first.collection, task, "s", TEXTS).repeated

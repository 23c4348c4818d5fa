"""A database that is gone, or takes questions and never answers: an error within seconds, and all goes on by itself."""

import os
import signal
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager

import pytest
import sqlalchemy as sa

from server.errors import StorageError
from server.runs import postgres
from server.runs.database import Database
from server.runs.journal import Journal
from server.runs.records import Batch
from tests.postgres import Cluster
from tests.runs.test_journal import a_run, steps


@pytest.fixture
def database(postgres_url: str) -> Iterator[Database]:
    with closing(Database(postgres_url)) as database:
        Journal(database).create(a_run(), ["a"])
        yield database


@contextmanager
def away(cluster: Cluster) -> Iterator[None]:
    cluster.crash()
    try:
        yield
    finally:
        cluster.start()


def test_a_database_that_was_away_is_used_again_and_holds_what_was_committed(
    cluster: Cluster, database: Database
) -> None:
    journal = Journal(database)
    journal.commit(steps("r", "a", 0, 1))
    with away(cluster):
        for _ in range(3):
            with pytest.raises(StorageError, match=r"the journal cannot be used: .*connection"):
                journal.commit(steps("r", "a", 2, first=2))
            with pytest.raises(StorageError, match=r"the journal cannot be used: .*connection"):
                journal.run("r")
    time.sleep(postgres.FRESH_SECONDS)
    assert journal.actions("r", "a") == [0, 1]
    journal.commit(steps("r", "a", 2, first=2))
    assert journal.actions("r", "a") == [0, 1, 2]


def test_a_database_that_went_and_came_while_nobody_looked_is_not_an_error(
    cluster: Cluster, database: Database
) -> None:
    journal = Journal(database)
    journal.commit(steps("r", "a", 0))
    with away(cluster):
        pass
    time.sleep(postgres.FRESH_SECONDS)
    journal.commit(steps("r", "a", 1, first=1))
    assert journal.actions("r", "a") == [0, 1]


def test_a_connection_lost_within_a_transaction_leaves_nothing_behind(cluster: Cluster, database: Database) -> None:
    def lose_the_connection() -> None:
        with database.write() as connection:
            (own,) = connection.execute(sa.select(sa.func.pg_backend_pid())).one()
            connection.execute(sa.text("INSERT INTO steps VALUES ('r', 'a', 0, 1)"))
            cluster.run("SELECT pg_terminate_backend(%(own)s)", own=own)
            connection.execute(sa.text("INSERT INTO steps VALUES ('r', 'a', 1, 1)"))

    with pytest.raises(StorageError, match="the journal cannot be used"):
        lose_the_connection()
    assert Journal(database).actions("r", "a") == []


def test_a_database_that_never_answers_is_given_up_and_then_left_in_peace(
    cluster: Cluster, database: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(postgres._Connection, "answer_seconds", 1.0)
    monkeypatch.setattr(postgres, "CONNECT_SECONDS", 2)
    journal = Journal(database)
    batch = Batch()
    batch.add_step("r", "a", 0, 0, 3)
    with frozen(cluster):
        with pytest.raises(StorageError, match="the database has not answered for 1 s"):
            journal.run("r")
        assert database._resting > time.monotonic()
        with pytest.raises(StorageError, match="the database has not answered for 1 s"):
            journal.commit(batch)
        database._resting = 0.0  # or the test would wait for it
        with pytest.raises(StorageError, match="timeout"):  # there is no new connection, either
            journal.commit(batch)
    database._resting = 0.0  # or the test would wait for it
    journal.commit(batch)
    assert journal.actions("r", "a") == [3]


@contextmanager
def frozen(cluster: Cluster) -> Iterator[None]:
    """All of the server's processes stand still: what is sent to them arrives, and nothing comes back."""
    processes = [*cluster.processes()]
    for process in processes:
        os.kill(process, signal.SIGSTOP)
    try:
        yield
    finally:
        for process in processes:
            os.kill(process, signal.SIGCONT)


def test_who_stands_still_in_a_transaction_does_not_keep_others_out(database: Database, postgres_url: str) -> None:
    journal, soon = Journal(database), "-c%20idle_in_transaction_session_timeout=500ms"

    def stand_still(stuck: Database) -> None:
        with stuck.write() as connection:
            connection.execute(sa.text("SELECT 1 FROM run_episodes FOR UPDATE"))
            assert len(journal.claim("r", journal.pending("r"), "p", "w")) == 1  # waits until the lock is gone
            connection.execute(sa.text("SELECT 1"))

    with (
        closing(Database(f"{postgres_url}?options={soon}")) as stuck,
        pytest.raises(StorageError, match="idle-in-transaction timeout"),
    ):
        stand_still(stuck)


def test_a_server_sets_its_own_limits(database: Database) -> None:
    with database.write() as connection:
        found = {
            name: connection.exec_driver_sql(f"SHOW {name}").scalar_one()
            for name in ("statement_timeout", "lock_timeout", "idle_in_transaction_session_timeout", "timezone")
        }
    assert list(found.values()) == ["6s", "4s", "6s", "UTC"]

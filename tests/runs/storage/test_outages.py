"""A database that is down or never answers: errors within seconds, and recovery without intervention."""

import os
import signal
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager

import pytest
import sqlalchemy as sa

from arramon_server.errors import StorageError
from arramon_server.runs.storage import postgres
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import CommitBatch
from tests.postgres import Cluster
from tests.runs.storage.test_journal import a_run, steps


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


def test_database_is_usable_after_an_outage_with_all_commits(cluster: Cluster, database: Database) -> None:
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


def test_an_outage_between_two_uses_is_not_an_error(cluster: Cluster, database: Database) -> None:
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


def test_unresponsive_database_times_out_and_is_paused(
    cluster: Cluster, database: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    journal = Journal(database)
    batch = CommitBatch()
    batch.add_step("r", "a", 0, 0, 3)
    with monkeypatch.context() as hasty, frozen(cluster):
        hasty.setattr(postgres._Connection, "answer_seconds", 1.0)
        hasty.setattr(postgres, "CONNECT_SECONDS", 2)
        with pytest.raises(StorageError, match="the database has not answered for 1 s"):
            journal.run("r")
        assert database._paused_until > time.monotonic()
        with pytest.raises(StorageError, match="the database has not answered for 1 s"):
            journal.commit(batch)
        database._paused_until = 0.0  # or the test would wait for it
        with pytest.raises(StorageError, match="timeout"):  # there is no new connection, either
            journal.commit(batch)
    database._paused_until = 0.0  # or the test would wait for it
    journal.commit(batch)
    assert journal.actions("r", "a") == [3]


@contextmanager
def frozen(cluster: Cluster) -> Iterator[None]:
    """Stop all processes of the database server: connections stay open, and nothing is answered."""
    processes = [*cluster.processes()]
    for process in processes:
        os.kill(process, signal.SIGSTOP)
    try:
        yield
    finally:
        for process in processes:
            os.kill(process, signal.SIGCONT)


def test_a_stalled_transaction_does_not_block_others_for_long(database: Database, postgres_url: str) -> None:
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


def test_database_sessions_have_the_servers_timeouts(database: Database) -> None:
    with database.write() as connection:
        found = {
            name: connection.exec_driver_sql(f"SHOW {name}").scalar_one()
            for name in ("statement_timeout", "lock_timeout", "idle_in_transaction_session_timeout", "timezone")
        }
    assert list(found.values()) == ["6s", "4s", "6s", "UTC"]

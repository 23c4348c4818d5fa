"""Two processes that both assume to hold an episode: the one that lost its claim can never write.

On PostgreSQL, where several write at once. SQLite has one writer at a time: what holds there, test_journal shows.
"""

import time
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, contextmanager
from threading import Event
from typing import Any

import psycopg
import pytest
from sqlalchemy import event

from arramon_server.errors import TakenOver
from arramon_server.runs.storage import postgres
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import Claim, CommitBatch, EpisodeEnding
from tests.runs.storage.test_journal import a_run

AT_MOST = 120.0
"""Seconds after which a thread is given up that never ends; nothing waits for so long on purpose."""


UNLIMITED = "?options=" + "%20".join(
    f"-c%20{name}=0" for name in ("lock_timeout", "statement_timeout", "idle_in_transaction_session_timeout")
)
"""For a database's URL: who waits for a lock here waits until the test lets go, however slow the machine is."""


@pytest.fixture
def databases(postgres_url: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Database, Database]]:
    """Return the connections of two processes to one database with a run of two episodes."""
    monkeypatch.setattr(postgres._Connection, "answer_seconds", AT_MOST)
    url = postgres_url + UNLIMITED
    with closing(Database(url)) as one, closing(Database(url)) as other:
        Journal(one).create(a_run(), ["a", "b"])
        yield one, other


def claimed(database: Database) -> Claim:
    journal = Journal(database)
    (claim,) = journal.claim("r", journal.pending("r", 1), "p", "w")
    return claim


def step(fence: int, number: int = 0) -> CommitBatch:
    batch = CommitBatch()
    batch.add_step("r", "a", fence, number, 1)
    return batch


@contextmanager
def paused_at_a_step(database: Database) -> Iterator[None]:
    """Pause every writer in the middle of writing a step until the block ends."""
    wait = "BEGIN PERFORM pg_advisory_xact_lock(1); RETURN NEW; END"
    with database.write() as connection:
        connection.exec_driver_sql(f"CREATE FUNCTION wait() RETURNS trigger LANGUAGE plpgsql AS $${wait}$$")
        connection.exec_driver_sql("CREATE TRIGGER waits BEFORE INSERT ON steps FOR EACH ROW EXECUTE FUNCTION wait()")
    with database.write() as connection:
        connection.exec_driver_sql("SELECT pg_advisory_xact_lock(1)")
        yield


@contextmanager
def paused_before_commit(database: Database) -> Iterator[Event]:
    """Pause the next transaction of a database before its commit until the block ends."""
    reached, go_on = Event(), Event()

    def pause(_: object) -> None:
        reached.set()
        assert go_on.wait(AT_MOST)

    event.listen(database._engine, "commit", pause, once=True)
    try:
        yield reached
    finally:
        go_on.set()


class Locks:
    """PostgreSQL's own account of the sessions of one database that wait for a lock, and of those that hold it."""

    def __init__(self, url: str) -> None:
        self._connection = psycopg.connect(url, autocommit=True)

    def close(self) -> None:
        self._connection.close()

    def blocked(self) -> dict[int, list[int]]:
        """For each waiting session the sessions that it waits for, by process id."""
        rows = self._connection.execute(
            "SELECT pid, pg_blocking_pids(pid) FROM pg_stat_activity"
            " WHERE datname = current_database() AND wait_event_type = 'Lock'"
        ).fetchall()
        return {waiting: holders for waiting, holders in rows if holders}

    def blocks(self, future: "Future[Any]", sessions: int = 1) -> bool:
        """Wait until so many sessions wait for a lock, or the future has got through; return whether they wait."""
        while not future.done():
            if len(self.blocked()) == sessions:
                return not future.done()
            time.sleep(0.01)
        return False


@pytest.fixture
def locks(postgres_url: str) -> Iterator[Locks]:
    with closing(Locks(postgres_url)) as locks:
        yield locks


def test_lock_detection_ignores_slow_work(locks: Locks) -> None:
    with ThreadPoolExecutor() as pool:
        assert not locks.blocks(pool.submit(time.sleep, 1.0))


def test_claim_waits_for_a_concurrent_step_and_sees_it(databases: tuple[Database, Database], locks: Locks) -> None:
    one, other = databases
    claim = claimed(one)
    journal = Journal(other)
    with ThreadPoolExecutor() as pool:
        with paused_at_a_step(other):
            writing = pool.submit(Journal(one).commit, step(claim.fence))
            assert locks.blocks(writing)
            taking = pool.submit(journal.claim, "r", journal.open_claims("r"), "p", "w2")
            assert locks.blocks(taking, sessions=2)
        writing.result(AT_MOST)
        (taken,) = taking.result(AT_MOST)
    assert taken.fence == claim.fence + 1
    assert journal.actions("r", "a") == [1]
    journal.commit(step(taken.fence, number=1))


def test_a_claim_waits_for_a_commit_of_several_statements(databases: tuple[Database, Database], locks: Locks) -> None:
    one, other = databases
    claim = claimed(one)
    batch = step(claim.fence)
    batch.charge("r", 1.0)
    with ThreadPoolExecutor() as pool:
        with paused_before_commit(one) as reached:
            writing = pool.submit(Journal(one).commit, batch)
            assert reached.wait(AT_MOST)
            journal = Journal(other)
            taking = pool.submit(journal.claim, "r", journal.open_claims("r"), "p", "w2")
            assert locks.blocks(taking)
        writing.result(AT_MOST)
        assert [taken.fence for taken in taking.result(AT_MOST)] == [claim.fence + 1]
    assert journal.actions("r", "a") == [1]


def test_batch_of_steps_is_written_completely_or_not_at_all(databases: tuple[Database, Database]) -> None:
    journal = Journal(databases[0])
    claims = journal.claim("r", journal.pending("r"), "p", "w")
    (again,) = journal.claim("r", [claims[1]], "q", "w2")
    batch = CommitBatch()
    for claim in claims:
        for number in range(3):
            batch.add_step("r", claim.episode_id, claim.fence, number, number)
    with pytest.raises(TakenOver, match="taken over"):
        journal.commit(batch)
    assert journal.progress("r").steps == 0
    assert journal.lost_episodes(batch) == {("r", again.episode_id)}
    journal.commit(batch.without({("r", again.episode_id)}))
    assert journal.actions("r", claims[0].episode_id) == [0, 1, 2]
    assert journal.progress("r").steps == 3


@pytest.mark.parametrize("writes", ["a step", "an ending", "both"])
def test_a_write_during_a_claim_waits_and_is_refused(
    databases: tuple[Database, Database], locks: Locks, writes: str
) -> None:
    one, other = databases
    claim = claimed(one)
    batch = CommitBatch() if writes == "an ending" else step(claim.fence)
    if writes != "a step":
        batch.endings.append(EpisodeEnding("r", "a", "AGENT_FINISHED", 1, [{}, {}], "", claim.fence))
    with ThreadPoolExecutor() as pool:
        with paused_before_commit(other) as reached:
            journal = Journal(other)
            taking = pool.submit(journal.claim, "r", journal.open_claims("r"), "p", "w2")
            assert reached.wait(AT_MOST)
            writing = pool.submit(Journal(one).commit, batch)
            assert locks.blocks(writing)
        assert [taken.fence for taken in taking.result(AT_MOST)] == [claim.fence + 1]
        with pytest.raises(TakenOver, match="taken over"):
            writing.result(AT_MOST)
    assert (journal.actions("r", "a"), journal.count_ended("r")) == ([], 0)


def test_only_one_of_two_concurrent_claims_wins(databases: tuple[Database, Database], locks: Locks) -> None:
    one, other = databases
    first, second = Journal(one), Journal(other)
    pending = first.pending("r")
    with ThreadPoolExecutor() as pool:
        with paused_before_commit(one) as reached:
            winning = pool.submit(first.claim, "r", pending, "p", "w1")
            assert reached.wait(AT_MOST)
            losing = pool.submit(second.claim, "r", pending, "q", "w2")
            assert locks.blocks(losing)
        assert [claim.episode_id for claim in winning.result(AT_MOST)] == ["a", "b"]
        assert losing.result(AT_MOST) == []
    assert {claim.player for claim in first.open_claims("r")} == {"p"}


def test_claim_waits_for_a_concurrent_ending_and_takes_nothing(
    databases: tuple[Database, Database], locks: Locks
) -> None:
    one, other = databases
    claim = claimed(one)
    ending = CommitBatch(endings=[EpisodeEnding("r", "a", "AGENT_FINISHED", 0, [{}, {}], "", claim.fence)])
    with ThreadPoolExecutor() as pool:
        with paused_before_commit(one) as reached:
            writing = pool.submit(Journal(one).commit, ending)
            assert reached.wait(AT_MOST)
            journal = Journal(other)
            taking = pool.submit(journal.claim, "r", journal.open_claims("r"), "p", "w2")
            assert locks.blocks(taking)
        writing.result(AT_MOST)
        assert taking.result(AT_MOST) == []
    assert journal.count_ended("r") == 1


def test_failed_transaction_frees_its_episodes(databases: tuple[Database, Database]) -> None:
    one, other = databases
    claim = claimed(one)
    batch = step(claim.fence)
    batch.charge("r", 1.0)

    def fail(_: object) -> None:
        raise ConnectionResetError

    event.listen(one._engine, "commit", fail, once=True)
    with pytest.raises(ConnectionResetError):
        Journal(one).commit(batch)
    journal = Journal(other)
    assert [taken.fence for taken in journal.claim("r", journal.open_claims("r"), "q", "w2")] == [claim.fence + 1]
    assert journal.actions("r", "a") == []

"""Two processes that both believe that an episode is theirs: whoever lost it cannot write, whatever the moment.

On PostgreSQL, where several write at once. SQLite has one writer at a time: what holds there, test_journal shows.
"""

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, contextmanager
from threading import Event
from typing import Any

import pytest
from sqlalchemy import event

from server.errors import TakenOver
from server.runs.database import Database
from server.runs.journal import Journal
from server.runs.records import Batch, Claim, Ending
from tests.runs.test_journal import a_run


@pytest.fixture
def databases(postgres_url: str) -> Iterator[tuple[Database, Database]]:
    """Two processes' own connections to one database, which holds a run of two episodes."""
    with closing(Database(postgres_url)) as one, closing(Database(postgres_url)) as other:
        Journal(one).create(a_run(), ["a", "b"])
        yield one, other


def claimed(database: Database) -> Claim:
    journal = Journal(database)
    (claim,) = journal.claim("r", journal.pending("r", 1), "p", "w")
    return claim


def step(epoch: int, number: int = 0) -> Batch:
    batch = Batch()
    batch.add_step("r", "a", epoch, number, 1)
    return batch


@contextmanager
def paused_at_a_step(database: Database) -> Iterator[None]:
    """Whoever writes a step stands still in the midst of it until the block ends."""
    wait = "BEGIN PERFORM pg_advisory_xact_lock(1); RETURN NEW; END"
    with database.write() as connection:
        connection.exec_driver_sql(f"CREATE FUNCTION wait() RETURNS trigger LANGUAGE plpgsql AS $${wait}$$")
        connection.exec_driver_sql("CREATE TRIGGER waits BEFORE INSERT ON steps FOR EACH ROW EXECUTE FUNCTION wait()")
    with database.write() as connection:
        connection.exec_driver_sql("SELECT pg_advisory_xact_lock(1)")
        yield


@contextmanager
def paused_before_commit(database: Database) -> Iterator[Event]:
    """The database's next transaction has done its work, and waits to be committed until the block ends."""
    reached, go_on = Event(), Event()

    def pause(_: object) -> None:
        reached.set()
        assert go_on.wait(30)

    event.listen(database._engine, "commit", pause, once=True)
    try:
        yield reached
    finally:
        go_on.set()


def waits(future: "Future[Any]") -> bool:
    """Whether it does not get anywhere. It takes milliseconds where nothing is in its way."""
    try:
        future.result(timeout=0.5)
    except TimeoutError:
        return True
    except TakenOver:
        pass
    return False


def test_a_claim_waits_for_a_step_that_is_being_written_and_sees_it(databases: tuple[Database, Database]) -> None:
    one, other = databases
    claim = claimed(one)
    journal = Journal(other)
    with ThreadPoolExecutor() as pool:
        with paused_at_a_step(other):
            writing = pool.submit(Journal(one).commit, step(claim.epoch))
            assert waits(writing)
            taking = pool.submit(journal.claim, "r", journal.open_claims("r"), "p", "w2")
            assert waits(taking)
        writing.result(10)
        (taken,) = taking.result(10)
    assert taken.epoch == claim.epoch + 1
    assert journal.actions("r", "a") == [1]
    journal.commit(step(taken.epoch, number=1))


def test_a_claim_waits_for_a_commit_of_several_statements(databases: tuple[Database, Database]) -> None:
    one, other = databases
    claim = claimed(one)
    batch = step(claim.epoch)
    batch.charge("r", 1.0)
    with ThreadPoolExecutor() as pool:
        with paused_before_commit(one) as reached:
            writing = pool.submit(Journal(one).commit, batch)
            assert reached.wait(10)
            journal = Journal(other)
            taking = pool.submit(journal.claim, "r", journal.open_claims("r"), "p", "w2")
            assert waits(taking)
        writing.result(10)
        assert [taken.epoch for taken in taking.result(10)] == [claim.epoch + 1]
    assert journal.actions("r", "a") == [1]


def test_of_many_steps_all_are_written_or_none(databases: tuple[Database, Database]) -> None:
    journal = Journal(databases[0])
    claims = journal.claim("r", journal.pending("r"), "p", "w")
    (again,) = journal.claim("r", [claims[1]], "q", "w2")
    batch = Batch()
    for claim in claims:
        for number in range(3):
            batch.add_step("r", claim.episode_id, claim.epoch, number, number)
    with pytest.raises(TakenOver, match="taken over"):
        journal.commit(batch)
    assert journal.progress("r").steps == 0
    assert journal.lost(batch) == {("r", again.episode_id)}
    journal.commit(batch.without({("r", again.episode_id)}))
    assert journal.actions("r", claims[0].episode_id) == [0, 1, 2]
    assert journal.progress("r").steps == 3


@pytest.mark.parametrize("writes", ["a step", "an ending", "both"])
def test_who_writes_while_the_episode_is_being_taken_waits_and_is_refused(
    databases: tuple[Database, Database], writes: str
) -> None:
    one, other = databases
    claim = claimed(one)
    batch = Batch() if writes == "an ending" else step(claim.epoch)
    if writes != "a step":
        batch.endings.append(Ending("r", "a", "AGENT_FINISHED", 1, [{}, {}], "", claim.epoch))
    with ThreadPoolExecutor() as pool:
        with paused_before_commit(other) as reached:
            journal = Journal(other)
            taking = pool.submit(journal.claim, "r", journal.open_claims("r"), "p", "w2")
            assert reached.wait(10)
            writing = pool.submit(Journal(one).commit, batch)
            assert waits(writing)
        assert [taken.epoch for taken in taking.result(10)] == [claim.epoch + 1]
        with pytest.raises(TakenOver, match="taken over"):
            writing.result(10)
    assert (journal.actions("r", "a"), journal.count_ended("r")) == ([], 0)


def test_of_two_claims_at_the_same_moment_one_wins(databases: tuple[Database, Database]) -> None:
    one, other = databases
    first, second = Journal(one), Journal(other)
    pending = first.pending("r")
    with ThreadPoolExecutor() as pool:
        with paused_before_commit(one) as reached:
            winning = pool.submit(first.claim, "r", pending, "p", "w1")
            assert reached.wait(10)
            losing = pool.submit(second.claim, "r", pending, "q", "w2")
            assert waits(losing)
        assert [claim.episode_id for claim in winning.result(10)] == ["a", "b"]
        assert losing.result(10) == []
    assert {claim.player for claim in first.open_claims("r")} == {"p"}


def test_an_ending_is_waited_for_and_then_nothing_is_left_to_claim(databases: tuple[Database, Database]) -> None:
    one, other = databases
    claim = claimed(one)
    ending = Batch(endings=[Ending("r", "a", "AGENT_FINISHED", 0, [{}, {}], "", claim.epoch)])
    with ThreadPoolExecutor() as pool:
        with paused_before_commit(one) as reached:
            writing = pool.submit(Journal(one).commit, ending)
            assert reached.wait(10)
            journal = Journal(other)
            taking = pool.submit(journal.claim, "r", journal.open_claims("r"), "p", "w2")
            assert waits(taking)
        writing.result(10)
        assert taking.result(10) == []
    assert journal.count_ended("r") == 1


def test_episodes_of_a_transaction_that_failed_are_free_again(databases: tuple[Database, Database]) -> None:
    one, other = databases
    claim = claimed(one)
    batch = step(claim.epoch)
    batch.charge("r", 1.0)

    def fail(_: object) -> None:
        raise ConnectionResetError

    event.listen(one._engine, "commit", fail, once=True)
    with pytest.raises(ConnectionResetError):
        Journal(one).commit(batch)
    journal = Journal(other)
    assert [taken.epoch for taken in journal.claim("r", journal.open_claims("r"), "q", "w2")] == [claim.epoch + 1]
    assert journal.actions("r", "a") == []

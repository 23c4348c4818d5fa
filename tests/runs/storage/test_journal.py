"""The journal returns what was written, and rejects duplicates."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import sqlalchemy as sa

from arramon_server.errors import BadInput, NotFound, StorageError, TakenOver
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import (
    CANCELLED,
    COMPLETE,
    RUNNING,
    CommitBatch,
    EpisodeEnding,
    Run,
    RunProgress,
)


def a_run(run_id: str = "r", minutes: int = 0) -> Run:
    at = datetime(2026, 1, 1, tzinfo=UTC) + timedelta(minutes=minutes)
    return Run(run_id, "lab", "walker", "tiny", "en", ("rgb",), 150, "f" * 64, "0.1.0", RUNNING, at)


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    with closing(Database(database_url)) as database:
        yield database


@pytest.fixture
def journal(database: Database) -> Journal:
    return Journal(database)


@pytest.fixture
def statements(database: Database) -> Iterator[list[str]]:
    """Return the list of executed statements, which grows as they are executed."""
    said: list[str] = []

    def note(*of: object) -> None:
        said.extend([str(of[2])] if str(of[2]).startswith("SELECT") else [])

    sa.event.listen(sa.Engine, "before_cursor_execute", note)
    yield said
    sa.event.remove(sa.Engine, "before_cursor_execute", note)


def steps(run_id: str, episode_id: str, *actions: int, first: int = 0) -> CommitBatch:
    batch = CommitBatch()
    for number, action in enumerate(actions, start=first):
        batch.add_step(run_id, episode_id, 0, number, action)
    return batch


def test_created_run_is_read_back_unchanged(journal: Journal) -> None:
    journal.create(a_run(), ["b", "a"])
    assert journal.run("r") == a_run()
    assert [claim.episode_id for claim in journal.pending("r")] == ["b", "a"]


def test_unknown_run_is_not_found(journal: Journal) -> None:
    with pytest.raises(NotFound, match="there is no run 'x'"):
        journal.run("x")


def test_steps_are_read_back_in_order(journal: Journal) -> None:
    journal.create(a_run(), ["a"])
    journal.commit(steps("r", "a", 0, 1, 2))
    journal.commit(steps("r", "a", 3, first=3))
    assert journal.actions("r", "a") == [0, 1, 2, 3]


def test_duplicate_step_is_refused_with_its_whole_batch(journal: Journal) -> None:
    journal.create(a_run(), ["a", "b"])
    journal.commit(steps("r", "a", 0))
    batch = steps("r", "b", 0, 0)
    batch.add_step("r", "a", 0, 0, 2)
    with pytest.raises(TakenOver, match="the journal contains this already"):
        journal.commit(batch)
    assert (journal.actions("r", "a"), journal.actions("r", "b")) == ([0], [])


def test_a_step_of_an_unknown_run_is_refused(journal: Journal) -> None:
    with pytest.raises(TakenOver, match="another process of this server has taken over"):
        journal.commit(steps("nobody's", "a", 0))


def test_claims_and_endings_update_the_progress(journal: Journal) -> None:
    journal.create(a_run(), ["a", "b", "c"])
    won = journal.claim("r", journal.pending("r", 2), "p", "w")
    assert [(claim.episode_id, claim.fence) for claim in won] == [("a", 1), ("b", 1)]
    journal.commit(
        CommitBatch(endings=[EpisodeEnding("r", "b", "AGENT_FINISHED", 7, [{"PTC": 1.0}, {"PTC": 0.0}], "fine", 1)])
    )
    assert [(claim.episode_id, claim.player) for claim in journal.open_claims("r")] == [("a", "p")]
    assert [claim.episode_id for claim in journal.pending("r", 5)] == ["c"]
    assert (journal.count_ended("r"), journal.count_unended("r")) == (1, 2)
    assert journal.endings("r")[0].scores == [{"PTC": 1.0}, {"PTC": 0.0}]
    batch = CommitBatch()
    for number in (0, 1):
        batch.add_step("r", "a", 1, number, 1)
    journal.commit(batch)
    assert journal.progress("r") == RunProgress(3, 1, 7 + 2, {"AGENT_FINISHED": 1})


def test_image_encodings_are_recorded_once_each(journal: Journal) -> None:
    journal.create(a_run(), ["a"])
    journal.create(a_run("other"), ["a"])
    assert journal.progress("r").images == ()
    for images in ("lossless-224", "jpeg90-224", "lossless-224"):
        journal.record_image_format("r", images)
    assert journal.progress("r").images == ("jpeg90-224", "lossless-224")
    assert journal.progress("other").images == ()


def test_episode_can_be_claimed_only_once(journal: Journal) -> None:
    journal.create(a_run(), ["a", "b"])
    pending = journal.pending("r")
    assert len(journal.claim("r", pending, "p", "w1")) == 2
    assert journal.claim("r", pending, "q", "w2") == []
    assert {claim.player for claim in journal.open_claims("r")} == {"p"}


def test_a_lost_claim_cannot_write(journal: Journal) -> None:
    journal.create(a_run(), ["a"])
    (first,) = journal.claim("r", journal.pending("r"), "p", "w1")
    (second,) = journal.claim("r", journal.open_claims("r"), "p", "w2")
    for batch in (
        CommitBatch(),
        CommitBatch(endings=[EpisodeEnding("r", "a", "FORFEITED", 0, [{}, {}], "", first.fence)]),
    ):
        if not batch.endings:
            batch.add_step("r", "a", first.fence, 0, 3)
        with pytest.raises(TakenOver, match="taken over"):
            journal.commit(batch)
    late = CommitBatch()
    late.add_step("r", "a", second.fence, 0, 1)
    journal.commit(late)
    assert journal.actions("r", "a") == [1]


def test_step_after_an_ending_is_refused(journal: Journal) -> None:
    journal.create(a_run(), ["a"])
    journal.commit(CommitBatch(endings=[EpisodeEnding("r", "a", "FORFEITED", 0, [{}, {}])]))
    with pytest.raises(TakenOver, match="or it has ended"):
        journal.commit(steps("r", "a", 0))


def test_open_claims_report_holder_and_idle_time(journal: Journal, database: Database) -> None:
    journal.create(a_run(), ["a"])
    journal.beat("w")
    (claim,) = journal.claim("r", journal.pending("r"), "p", "w")

    def seen() -> tuple[str | None, float]:
        (now,) = journal.open_claims("r")
        return now.worker, now.idle // 1000

    def last_seen(seconds: float) -> None:
        with database.write() as connection:
            connection.execute(tables.workers.update().values(seen=database.now - seconds))

    assert seen() == ("w", 0)
    last_seen(5500.0)
    assert seen() == ("w", 5)
    journal.beat("w")
    assert seen() == ("w", 0)
    last_seen(-7500.0)  # the clock jumped back
    assert seen() == ("w", 7)
    journal.release("r", {"a": claim.fence + 1})  # of another claim: nothing happens
    assert seen() == ("w", 7)
    journal.release("r", {"a": claim.fence})
    with database.write() as connection:
        connection.execute(tables.service_clock.update().values(seconds=tables.service_clock.c.seconds + 2500.0))
    assert seen() == (None, 2)
    (again,) = journal.claim("r", journal.open_claims("r"), "p", "w")
    journal.retire("w")
    worker, idle = seen()
    assert worker is None
    assert idle > 1e6
    journal.release("r", {"a": again.fence})
    assert seen() == (None, 0)


def test_killed_workers_are_eventually_removed(journal: Journal, database: Database) -> None:
    for worker in ("long gone", "killed"):
        journal.beat(worker)
        with database.write() as connection:
            connection.execute(tables.workers.update().values(seen=tables.workers.c.seen - 80_000.0))
    journal.beat("new")
    assert {row.worker_id for row in database.read(sa.select(tables.workers))} == {"killed", "new"}


def test_addresses_are_visible_on_their_own_host_only(database: Database) -> None:
    here, there = Journal(database), Journal(database, host="another")
    here.beat("1", "127.0.0.1:1")
    here.beat("2", "127.0.0.1:2")
    here.beat("3")
    there.beat("4", "127.0.0.1:1")
    assert here.addresses(5000.0) == ["127.0.0.1:1", "127.0.0.1:2"]
    assert there.addresses(5000.0) == ["127.0.0.1:1"]
    with database.write() as connection:
        gone = tables.workers.c.worker_id == "1"
        connection.execute(tables.workers.update().where(gone).values(seen=database.now - 9000.0))
    assert here.addresses(5000.0) == ["127.0.0.1:2"]


def test_the_first_end_of_a_run_is_final(journal: Journal) -> None:
    journal.create(a_run(), ["a"])
    journal.set_state("r", COMPLETE)
    ended = journal.run("r")
    journal.set_state("r", CANCELLED)
    assert journal.run("r") == ended
    assert (ended.state, ended.ended_at is not None) == (COMPLETE, True)


def test_runs_are_listed_latest_first(journal: Journal) -> None:
    for number, minutes in ((1, 5), (2, 0), (3, 5)):
        journal.create(a_run(f"r{number}", minutes), ["a"])
    assert [run.run_id for run in journal.runs(2)] == ["r3", "r1"]
    assert [run.run_id for run in journal.runs(2, journal.run("r1"))] == ["r2"]


@pytest.mark.parametrize("count", [1, 40])
def test_progress_of_many_runs_takes_few_queries(
    database: Database, journal: Journal, count: int, statements: list[str]
) -> None:
    names = [f"r{number}" for number in range(count)]
    for number, name in enumerate(names):
        journal.create(a_run(name), ["a", "b", "c"])
        (claim,) = journal.claim(name, journal.pending(name, 1), "p", "w")
        batch = CommitBatch()
        for step in range(number):
            batch.add_step(name, "a", claim.fence, step, 0)
        journal.commit(batch)
        journal.record_image_format(name, f"raw-{number}")
    statements.clear()
    found = journal.progress_of([*names, "x"])
    assert len(statements) == 4
    assert found == {
        **{name: RunProgress(3, 0, number, {}, (f"raw-{number}",)) for number, name in enumerate(names)},
        "x": RunProgress(0, 0, 0, {}, ()),
    }


def test_another_connection_reads_committed_data(journal: Journal, database_url: str) -> None:
    journal.create(a_run(), ["a"])
    journal.set_state("r", COMPLETE)
    with closing(Database(database_url)) as other:
        assert Journal(other).run("r").state == COMPLETE


def test_missing_journal_folder_is_reported(tmp_path: Path) -> None:
    with pytest.raises(
        StorageError, match=r"the journal .*/nowhere/journal\.db cannot be created: there is no folder .*/nowhere$"
    ):
        Database(f"sqlite:///{tmp_path / 'nowhere' / 'journal.db'}")


def test_a_full_disk_is_a_storage_error_and_loses_nothing(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'journal.db'}"
    with closing(Database(url)) as database:
        journal = Journal(database)
        journal.create(a_run(), ["a"])
        journal.commit(steps("r", "a", 0))
        with closing(Database(url)) as limited:
            with limited._engine.connect() as connection:
                connection.exec_driver_sql("PRAGMA max_page_count=1")
            with pytest.raises(StorageError, match="full"):
                Journal(limited).commit(steps("r", "a", *[1] * 50_000, first=1))
        assert journal.actions("r", "a") == [0]


def test_committed_steps_are_in_the_sqlite_file(tmp_path: Path) -> None:
    with closing(Database(f"sqlite:///{tmp_path / 'journal.db'}")) as database:
        journal = Journal(database)
        journal.create(a_run(), ["a"])
        journal.commit(steps("r", "a", 2, 3))
        with sqlite3.connect(f"file:{tmp_path / 'journal.db'}?mode=ro", uri=True) as raw:
            assert raw.execute("SELECT step, action FROM steps ORDER BY step").fetchall() == [(0, 2), (1, 3)]
            assert raw.execute("PRAGMA journal_mode").fetchone() == ("wal",)
        raw.close()


@pytest.mark.parametrize("url", ["mysql://lab:hunter2@host/db", "hunter2", "postgresql://lab:hunter2@host:port/db"])
def test_unsupported_url_is_refused_without_showing_its_password(url: str) -> None:
    with pytest.raises(BadInput, match="expected sqlite:///PATH or postgresql://USER:PASSWORD@HOST/NAME") as refused:
        Database(url)
    assert "hunter2" not in str(refused.value)


def test_null_characters_in_a_note_do_not_prevent_a_commit(journal: Journal) -> None:
    journal.create(a_run(), ["a"])
    journal.commit(CommitBatch(endings=[EpisodeEnding("r", "a", "FORFEITED", 0, [{}, {}], "no\0thing")]))
    assert journal.endings("r")[0].note == "nothing"


def test_values_that_a_database_cannot_store_are_bad_input(postgres_url: str) -> None:
    with closing(Database(postgres_url)) as database:
        with pytest.raises(BadInput, match="the journal cannot store this"):
            Journal(database).actions("r", "a\0b")
        with pytest.raises(BadInput, match="the journal cannot store this"):
            Journal(database).create(a_run("r" * 33), ["a"])


def test_journal_file_is_private_to_its_owner(tmp_path: Path) -> None:
    with closing(Database(f"sqlite:///{tmp_path / 'new.db'}")) as database:
        Journal(database).create(a_run(), ["a"])
        assert {path.stat().st_mode & 0o777 for path in tmp_path.glob("new.db*")} == {0o600}

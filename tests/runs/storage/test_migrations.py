"""Migrations: a database of any version is upgraded once, with all its data, also by concurrent processes."""

import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime
from multiprocessing import Pipe
from pathlib import Path

import pytest
import sqlalchemy as sa
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext

from arramon_server.errors import StorageError
from arramon_server.runs.storage.database import Database, utc
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.migrations import configuration, migrate
from arramon_server.runs.storage.records import COMPLETE, RUNNING, Batch
from arramon_server.runs.storage.tables import metadata
from tests import recorded_migrations
from tests.forked import Forked
from tests.postgres import Cluster

AT = datetime(2026, 1, 1, tzinfo=UTC)

RUN = {
    "participant": "lab",
    "agent": "walker",
    "split": "tiny",
    "language": "hi",
    "sensors": '["rgb", "depth"]',
    "steps_per_phase": 150,
    "data_hash": "f" * 64,
    "server_version": "0.1.0",
    "created_at": AT,
}

SCORES = [{"PTC": 1.0}, {"PTC": 0.0}]


@pytest.fixture(autouse=True)
def no_record() -> Iterator[None]:
    """Make databases by the migrations themselves, not by their record."""
    recorded_migrations.uninstall()
    yield
    recorded_migrations.install()


@pytest.fixture
def postgres_url(cluster: Cluster) -> str:
    """Return an empty database, which the migrations are applied to."""
    return cluster.create_empty()


@pytest.fixture
def engine(database_url: str) -> Iterator[sa.Engine]:
    """Return a connection of the test itself."""
    engine = sa.create_engine(database_url.replace("postgresql:", "postgresql+psycopg:"))
    yield engine
    engine.dispose()


@pytest.fixture
def first_schema(engine: sa.Engine) -> None:
    """Create a database with the first schema: an ended run, and a running one of two episodes."""
    with engine.begin() as connection:
        migrate(connection, "0001")
        for run_id, state in (("old", COMPLETE), ("new", RUNNING)):
            insert(connection, "runs", run_id=run_id, state=state, **RUN)
        ended = {"state": "ENDED", "cause": "AGENT_FINISHED", "note": "well", "steps": 2}
        scores = '[{"PTC": 1.0}, {"PTC": 0.0}]'
        insert(connection, "run_episodes", run_id="old", episode_id="a", ordinal=0, scores=scores, **ended)
        insert(connection, "run_episodes", run_id="new", episode_id="a", ordinal=0, state="OPEN", player="p")
        insert(connection, "run_episodes", run_id="new", episode_id="b", ordinal=1, state="PENDING")
        for run_id in ("old", "new"):
            for step, action in enumerate((0, 3)):
                insert(connection, "steps", run_id=run_id, episode_id="a", step=step, action=action)


def insert(connection: sa.Connection, table: str, **values: object) -> None:
    columns, marks = ", ".join(values), ", ".join(f":{name}" for name in values)
    statement = sa.text(f"INSERT INTO {table} ({columns}) VALUES ({marks})")
    # As the tables write times: Python 3.12 warns of its own way with SQLite.
    times = [name for name, value in values.items() if isinstance(value, datetime)]
    bound = statement.bindparams(*(sa.bindparam(name, type_=sa.DateTime(timezone=True)) for name in times))
    connection.execute(bound, values)


@pytest.mark.usefixtures("first_schema")
def test_database_of_the_first_schema_is_upgraded_with_its_data(database_url: str, engine: sa.Engine) -> None:
    with closing(Database(database_url)) as database:
        journal = Journal(database)
        old, new = journal.run("old"), journal.run("new")
        assert (old.participant, old.sensors, old.created_at, old.state) == ("lab", ("rgb", "depth"), AT, COMPLETE)
        assert (new.account, new.ended_at, new.bank_left, new.bank_seconds) == (None, None, None, 0)
        assert (old.agent_arguments, new.agent_arguments) == ((), ())
        (ending,) = journal.endings("old")
        assert (ending.cause, ending.note, ending.steps, ending.scores) == ("AGENT_FINISHED", "well", 2, SCORES)
        assert (journal.progress("old").steps, journal.progress("new").steps) == (2, 2)
        (orphan,) = journal.open_claims("new")
        assert (orphan.episode_id, orphan.player, orphan.epoch, orphan.worker) == ("a", "p", 0, None)
        (mine,) = journal.claim("new", [orphan], "q", "w")
        batch = Batch()
        batch.add_step("new", "a", mine.epoch, 2, 1)
        journal.commit(batch)
        assert journal.actions("new", "a") == [0, 3, 1]
        assert [claim.episode_id for claim in journal.pending("new")] == ["b"]
    if engine.dialect.name == "sqlite":
        with engine.connect() as connection:
            assert connection.exec_driver_sql("PRAGMA foreign_key_check").all() == []


def test_running_runs_get_their_time_away_into_the_bank(database_url: str, engine: sa.Engine) -> None:
    rows = {
        "new": (RUNNING, 3600.0, 1000.0, 0.0),
        "often away": (RUNNING, 3600.0, 0.0, 400.0),
        "too often": (RUNNING, 3600.0, 10.0, 90_000.0),
        "no clocks": (RUNNING, 0.0, None, 0.0),
        "over": (COMPLETE, 3600.0, 3.0, 0.0),
    }
    with engine.begin() as connection:
        migrate(connection, "0006")
        for run_id, (state, bank, left, away) in rows.items():
            values = {"bank_seconds": bank, "bank_left": left, "away": away, "active_at": 1.8e9}
            insert(connection, "runs", run_id=run_id, state=state, **values, **RUN)
    with closing(Database(database_url)) as database:
        runs = [Journal(database).run(run_id) for run_id in rows]
    assert [(run.bank_seconds, run.bank_left) for run in runs] == [
        (90_000.0, 87_400.0),
        (90_000.0, 86_000.0),
        (90_000.0, 10.0),
        (0.0, None),
        (3600.0, 3.0),
    ]


@pytest.mark.usefixtures("first_schema")
def test_foreign_keys_are_enforced_after_the_migrations(database_url: str) -> None:
    with closing(Database(database_url)) as database:
        for statement in (
            "INSERT INTO steps (run_id, episode_id, step, action) VALUES ('new', 'nowhere', 0, 0)",
            "UPDATE runs SET account = 'nobody' WHERE run_id = 'new'",
            "DELETE FROM runs WHERE run_id = 'old'",
        ):
            with (
                pytest.raises(Exception, match=r"(?i)foreign key constraint"),
                database.write() as connection,
            ):
                connection.exec_driver_sql(statement)


@pytest.mark.usefixtures("first_schema")
def test_the_migrations_can_be_reverted(database_url: str, engine: sa.Engine) -> None:
    Database(database_url).close()
    with engine.begin() as connection:
        command.downgrade(configuration(connection), "0001")
        rows = connection.execute(sa.text("SELECT * FROM runs ORDER BY run_id")).all()
        assert [(row.run_id, utc(row.created_at) if engine.dialect.name != "sqlite" else AT) for row in rows] == [
            ("new", AT),
            ("old", AT),
        ]
        assert set(rows[0]._fields) == {"run_id", "state", *RUN}
        assert set(sa.inspect(connection).get_table_names()) == {"runs", "run_episodes", "steps", "alembic_version"}
    Database(database_url).close()


def test_migrations_produce_the_declared_tables(database_url: str, engine: sa.Engine) -> None:
    Database(database_url).close()
    with engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), metadata) == []


@pytest.mark.parametrize("age", ["empty", "first schema"])
def test_concurrent_processes_migrate_once(
    database_url: str, age: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    if age == "first schema":
        request.getfixturevalue("first_schema")
    log = tmp_path / "log"
    said, says = Pipe(duplex=False)
    with said, says:
        processes = [Forked([database_url], says, log, recorded_migrations.open_unrecorded) for _ in range(4)]
    assert [process.wait(240) for process in processes] == [0, 0, 0, 0], log.read_text()
    with closing(Database(database_url)) as database:
        assert len(Journal(database).runs(9)) == (2 if age == "first schema" else 0)


def test_database_of_a_newer_server_is_refused(database_url: str, engine: sa.Engine) -> None:
    Database(database_url).close()
    with engine.begin() as connection:
        connection.execute(sa.text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(
        StorageError, match=r"written by another version of this server:.*9999.*supports version 0013 of the tables"
    ):
        Database(database_url)


def test_the_tests_record_leaves_the_same_as_the_migrations(tmp_path: Path) -> None:
    """Other tests make their databases by it."""
    dumps = []
    for prepare in (recorded_migrations.uninstall, recorded_migrations.install):
        prepare()
        file = tmp_path / f"{prepare.__name__}.db"
        started = time.time()
        Database(f"sqlite:///{file}").close()
        with closing(sqlite3.connect(file)) as connection:
            (clock,) = connection.execute("SELECT * FROM service_clock").fetchall()
            assert clock[0] == 1
            assert started <= clock[1] == clock[2] <= time.time()
            connection.execute("DELETE FROM service_clock")
            dumps.append(sorted(connection.iterdump()))
    assert dumps[0] == dumps[1]
    assert len(dumps[0]) > 15

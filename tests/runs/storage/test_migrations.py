"""Migrations: make the declared tables, once, also by concurrent processes; refuse databases of other versions."""

import time
from collections.abc import Iterator
from contextlib import closing
from multiprocessing import Pipe
from pathlib import Path

import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext

from arramon_server.errors import StorageError
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.tables import metadata
from tests.forked import Forked
from tests.postgres import Cluster


@pytest.fixture
def postgres_url(cluster: Cluster) -> Iterator[str]:
    """Return an empty database, which the migrations are applied to."""
    url = cluster.create_empty()
    yield url
    cluster.drop(url)


@pytest.fixture
def engine(database_url: str) -> Iterator[sa.Engine]:
    """Return a connection of the test itself."""
    engine = sa.create_engine(database_url.replace("postgresql:", "postgresql+psycopg:"))
    yield engine
    engine.dispose()


def test_migrations_produce_the_declared_tables(database_url: str, engine: sa.Engine) -> None:
    Database(database_url).close()
    with engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), metadata) == []


def test_a_new_database_has_one_service_clock_at_the_present(database_url: str, engine: sa.Engine) -> None:
    started = time.time()
    Database(database_url).close()
    with engine.connect() as connection:
        ((number, seconds, seen),) = connection.execute(sa.text("SELECT * FROM service_clock"))
    assert number == 1
    assert started <= seconds == seen <= time.time()


def test_foreign_keys_are_enforced(database_url: str) -> None:
    with closing(Database(database_url)) as database:
        for statement in (
            "INSERT INTO steps (run_id, episode_id, step, action) VALUES ('new', 'nowhere', 0, 0)",
            "INSERT INTO tokens VALUES ('t', 'nobody', 'h', '', '2026-01-01', NULL, NULL)",
            "INSERT INTO streams VALUES ('s', 'nowhere', 'p', 'w', '2026-01-01')",
        ):
            with (
                pytest.raises(Exception, match=r"(?i)foreign key constraint"),
                database.write() as connection,
            ):
                connection.exec_driver_sql(statement)


def _open(arguments: list[str]) -> int:
    """Open the database with this URL in a process of its own."""
    Database(*arguments).close()
    return 0


def test_concurrent_processes_migrate_once(database_url: str, tmp_path: Path) -> None:
    log = tmp_path / "log"
    said, says = Pipe(duplex=False)
    with said, says:
        processes = [Forked([database_url], says, log, _open) for _ in range(4)]
    assert [process.wait(240) for process in processes] == [0, 0, 0, 0], log.read_text()
    with closing(Database(database_url)) as database:
        assert Journal(database).runs(9) == []


def _set_revision(engine: sa.Engine, revision: str) -> None:
    with engine.begin() as connection:
        connection.execute(sa.text("UPDATE alembic_version SET version_num = :revision"), {"revision": revision})


def test_database_of_a_newer_server_is_refused(database_url: str, engine: sa.Engine) -> None:
    Database(database_url).close()
    _set_revision(engine, "9999")
    with pytest.raises(
        StorageError, match=r"written by another version of this server:.*9999.*supports tables up to version 0015"
    ):
        Database(database_url)


@pytest.mark.parametrize("read_only", [False, True])
@pytest.mark.parametrize("revision", ["0001", "0012"])
def test_database_of_a_development_version_is_refused(
    database_url: str, engine: sa.Engine, revision: str, read_only: bool
) -> None:
    """And stays as it is: the version that wrote it must be able to export it."""
    Database(database_url).close()
    _set_revision(engine, revision)
    with pytest.raises(StorageError, match=rf"version {revision}, of a development.*`arramon-server export` of the"):
        Database(database_url, read_only=read_only)
    with engine.connect() as connection:
        assert connection.execute(sa.text("SELECT version_num FROM alembic_version")).scalar_one() == revision

"""Migrations of the database schema, applied when `database.Database` opens a database."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy.engine import Connection

from arramon_server.errors import StorageError

FIRST = "0013"
"""The oldest revision that can be upgraded; lower ones are of development versions, before the first release."""


def migrate(connection: Connection, revision: str = "head") -> None:
    """Upgrade a database to a revision, in the transaction of the connection.

    Raises:
        StorageError: if the database has a revision lower than FIRST.
        alembic.util.CommandError: if the database has a revision unknown to this version.
    """
    check_revision(revision_of(connection))
    command.upgrade(configuration(connection), revision)


def check_revision(revision: str | None) -> None:
    """Check that a database of a revision can be upgraded; None is an empty database, unknown revisions pass.

    Raises:
        StorageError: if the revision is lower than FIRST.
    """
    if revision is not None and revision < FIRST:
        raise StorageError(
            f"the journal has tables of version {revision}, of a development version of this server; expected {FIRST} "
            "or later. Run `arramon-server export` of the version that wrote it, and `arramon-server import` of this "
            "one into a new journal"
        )


def newest_revision() -> str | None:
    """Return the newest revision, to which `migrate` upgrades."""
    return ScriptDirectory.from_config(configuration()).get_current_head()


def revision_of(connection: Connection) -> str | None:
    """Return the revision of a database; None if it was never migrated."""
    return MigrationContext.configure(connection).get_current_revision()


def configuration(connection: Connection | None = None) -> Config:
    """Return the configuration of Alembic for a connection; None for commands without one."""
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent).replace("%", "%%"))
    config.attributes["connection"] = connection
    return config
